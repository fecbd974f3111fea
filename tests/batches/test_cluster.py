"""Dask workers, on loopback alone, give the same rows: plain, with TLS, and when one of them is killed."""

from __future__ import annotations

import datetime
import ipaddress
import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from reproduced import rows

import holdfast as hf

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.usefixtures("drill")
LOOPBACK = "127.0.0.1"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Twelve scenes, two of which end badly."""
    made = tmp_path / "in"
    made.mkdir()
    for k in range(12):
        (made / f"{k}.yaml").write_text(f"slow {k}")
    (made / "4.yaml").write_text("exit")
    (made / "7.yaml").write_text("eat")
    return made


def same(folder: Path, scheduler: Any) -> None:
    """Ask twice, here and there, and compare."""
    limits: dict[str, Any] = {"megabytes": 1000, "shard_size": 5}
    scenes = str(folder / "*.yaml")
    here = hf.batch(scenes, out=folder.parent / "here", workers=2, resources=hf.sets.Resources(**limits))
    there = hf.batch(scenes, out=folder.parent / "there", resources=hf.sets.Resources(scheduler=scheduler, **limits))
    assert dict(here.outcomes) == dict(there.outcomes) == {"answered": 10, "memory": 1, "crash": 1}
    assert rows(folder.parent / "there") == rows(folder.parent / "here")


def test_a_local_cluster_gives_the_same_rows(folder: Path) -> None:
    options: dict[str, Any] = {"n_workers": 1, "threads_per_worker": 2, "processes": False, "dashboard_address": None}
    options |= {"host": LOOPBACK, "protocol": "tcp"}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        assert cluster.scheduler_address.startswith(f"tcp://{LOOPBACK}:")
        same(folder, client)


@pytest.mark.slow
def test_separate_workers_with_tls_one_of_them_killed(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("cryptography")
    for k in range(20, 60):
        (folder / f"{k}.yaml").write_text(f"slow {k}")
    files = certificates(tmp_path)
    with processes(files, tmp_path) as (address, workers):
        assert address.startswith(f"tls://{LOOPBACK}")
        with pytest.raises(hf.HoldfastError, match="cannot be reached"):
            hf.batch(str(folder / "*.yaml"), resources=hf.sets.Resources(scheduler=address), out=folder.parent / "none")
        names = {"tls_ca_file": files["ca"], "tls_client_cert": files["cert"], "tls_client_key": files["key"]}
        security = distributed.Security(require_encryption=True, **{key: str(path) for key, path in names.items()})
        with distributed.Client(address, security=security) as client:
            client.wait_for_workers(2)
            scenes, limits = str(folder / "*.yaml"), {"megabytes": 1000, "shard_size": 5}
            here = hf.batch(scenes, out=folder.parent / "here", workers=2, resources=hf.sets.Resources(**limits))
            killer = threading.Timer(1.5, workers[0].kill)
            killer.start()
            there = hf.batch(
                scenes, out=folder.parent / "there", resources=hf.sets.Resources(scheduler=client, **limits)
            )
            killer.join()
            assert workers[0].wait() == -signal.SIGKILL
        assert dict(here.outcomes) == dict(there.outcomes)
        assert rows(folder.parent / "there") == rows(folder.parent / "here")


@pytest.mark.parametrize("tls", [False, True], ids=["tcp", "tls"])
def test_the_command_asks_by_address(folder: Path, tmp_path: Path, tls: bool) -> None:
    files = certificates(tmp_path) if tls else None
    (folder / "4.yaml").write_text("slow 4")
    (folder / "7.yaml").write_text("slow 7")
    with processes(files, tmp_path) as (address, _):
        assert address.startswith("tls:" if tls else "tcp:")
        options = {f"--tls-{name}": str(path) for name, path in (files or {}).items()}
        command = [sys.executable, "-m", "holdfast", "batch", str(folder), "--out", str(tmp_path / "out")]
        command += ["--scheduler", address, *(part for option in options.items() for part in option)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=100)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "12 answered" in done.stdout
    assert {row["reason"] for row in hf.read_batch(tmp_path / "out").rows()} == {f"slow {k}" for k in range(12)}


def test_tls_by_address_takes_its_certificates_from_dasks_own_configuration(folder: Path, tmp_path: Path) -> None:
    import dask

    files = certificates(tmp_path)
    names = {"ca-file": str(files["ca"]), "client.cert": str(files["cert"]), "client.key": str(files["key"])}
    with processes(files, tmp_path) as (address, _):
        with pytest.raises(hf.HoldfastError, match="cannot be reached"):
            hf.batch(str(folder / "*.yaml"), resources=hf.sets.Resources(scheduler=address), out=tmp_path / "none")
        with dask.config.set({f"distributed.comm.tls.{name}": path for name, path in names.items()}):
            same(folder, address)


class processes:  # noqa: N801 - used as a function
    """A scheduler and two workers as processes of their own, on loopback, as a context; TLS if there are files."""

    def __init__(self, files: dict[str, Path] | None, folder: Path) -> None:
        known = {"ca-file": "ca", "cert": "cert", "key": "key"}
        self.tls = [part for name, key in known.items() if files for part in (f"--tls-{name}", files[key])]
        self.protocol = "tls" if files else "tcp"
        self.file, self.folder = folder / "scheduler.json", folder
        self.started: list[subprocess.Popen[bytes]] = []

    def run(self, kind: str, *arguments: object) -> subprocess.Popen[bytes]:
        start = "from holdfast.batches import workers\nworkers.ANSWERED_BY = 'batch_drill:answered'\n"
        command = [sys.executable, "-c", f"{start}from {kind} import main\nmain()", *map(str, (*self.tls, *arguments))]
        log = (self.folder / f"{len(self.started)}.log").open("wb")
        self.started.append(subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder))
        return self.started[-1]

    def __enter__(self) -> tuple[str, list[subprocess.Popen[bytes]]]:
        where = ("--host", LOOPBACK, "--port", 0, "--protocol", self.protocol, "--no-dashboard")
        self.run("distributed.cli.dask_scheduler", *where, "--scheduler-file", self.file)
        until = time.monotonic() + 60
        while not self.file.exists():
            assert time.monotonic() < until, (self.folder / "0.log").read_text()
            time.sleep(0.1)
        time.sleep(0.5)
        address = json.loads(self.file.read_text())["address"]
        own = ("--local-directory", self.folder)
        options = ("--host", LOOPBACK, "--nthreads", 1, "--no-nanny", "--no-dashboard", *own)
        workers = [self.run("distributed.cli.dask_worker", address, *options) for _ in range(2)]
        return address, workers

    def __exit__(self, *failure: object) -> None:
        for process in self.started:
            process.kill()
            process.wait()


def certificates(folder: Path) -> dict[str, Path]:
    """A certificate authority, and a key with a certificate by it for loopback."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec

    def name(text: str) -> x509.Name:
        return x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, text)])

    now = datetime.datetime.now(datetime.UTC)

    def signed(subject: str, key: Any, issuer: Any, *, authority: bool) -> x509.Certificate:
        made = x509.CertificateBuilder().subject_name(name(subject)).issuer_name(name("holdfast tests"))
        made = made.public_key(key.public_key()).serial_number(x509.random_serial_number())
        made = made.not_valid_before(now - datetime.timedelta(1)).not_valid_after(now + datetime.timedelta(1))
        made = made.add_extension(x509.BasicConstraints(ca=authority, path_length=None), critical=True)
        address = x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address(LOOPBACK))])
        return made.add_extension(address, critical=False).sign(issuer, hashes.SHA256())

    root, own = ec.generate_private_key(ec.SECP256R1()), ec.generate_private_key(ec.SECP256R1())
    pem, plain = serialization.Encoding.PEM, serialization.NoEncryption()
    content = {
        "ca": signed("holdfast tests", root, root, authority=True).public_bytes(pem),
        "cert": signed("holdfast worker", own, root, authority=False).public_bytes(pem),
        "key": own.private_bytes(pem, serialization.PrivateFormat.PKCS8, plain),
    }
    paths = {key: folder / f"{key}.pem" for key in content}
    for key, path in paths.items():
        path.write_bytes(content[key])
    return paths


def test_a_scheduler_that_is_none_is_told(folder: Path) -> None:
    with pytest.raises(hf.HoldfastError, match="got 3"):
        hf.batch(str(folder / "*.yaml"), resources=hf.sets.Resources(scheduler=3), out=folder.parent / "out")  # type: ignore[arg-type]


@pytest.fixture(scope="module", autouse=True)
def end_keepers() -> Iterator[None]:
    """End the workers of clusters in this process."""
    yield
    from holdfast.batches.workers import close_supervisors

    close_supervisors()
