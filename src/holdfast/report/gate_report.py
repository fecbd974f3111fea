"""The findings of a check as JUnit XML, which CI servers show, and as a summary for the page of a CI run."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from xml.etree import ElementTree as Xml

from holdfast import __version__
from holdfast.base.files import write_atomically
from holdfast.base.text import many, one_line
from holdfast.batches.gate import FAILED, PASSED, UNDECIDED, Finding
from holdfast.report.description import LONGEST_REASON, MOST_ROWS, ReportTable


def counted(findings: Sequence[Finding]) -> str:
    """Return how many scenes passed, failed and are undecided, in words."""
    counts = Counter(finding.result for finding in findings)
    return ", ".join(f"{counts[result]:,} {result}" for result in (PASSED, FAILED, UNDECIDED))


def write_junit(findings: Sequence[Finding], path: str | os.PathLike[str]) -> None:
    """Write a test case for each scene: a failure if it failed, an error if it is undecided, with reason and remedy.

    The layout is that of Ant's JUnit task, which the schemas of Windy Road and of Jenkins' xunit plugin describe. A
    scene is a case, not a body: whether a body stands depends on the others.
    """
    counts = Counter(finding.result for finding in findings)
    about = {
        "name": "holdfast check",
        "package": "holdfast",
        "id": "0",
        "timestamp": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S"),
        "hostname": "localhost",
        "tests": str(len(findings)),
        "failures": str(counts[FAILED]),
        "errors": str(counts[UNDECIDED]),
        "skipped": "0",
        "time": f"{sum(finding.seconds for finding in findings):.3f}",
    }
    root = Xml.Element("testsuites")
    suite = Xml.SubElement(root, "testsuite", about)
    properties = Xml.SubElement(suite, "properties")
    Xml.SubElement(properties, "property", {"name": "holdfast", "value": __version__})
    for finding in findings:
        case = {"classname": "holdfast", "name": one_line(finding.scene), "time": f"{finding.seconds:.3f}"}
        element = Xml.SubElement(suite, "testcase", case)
        if finding.result != PASSED:
            kind, reason = "failure" if finding.result == FAILED else "error", one_line(finding.reason, LONGEST_REASON)
            why = Xml.SubElement(element, kind, {"type": finding.result, "message": reason})
            why.text = f"{reason}\n{finding.remedy}".strip()
    for stream in ("system-out", "system-err"):
        Xml.SubElement(suite, stream)
    Xml.indent(root)
    write_atomically(path, Xml.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n")


def write_summary(findings: Sequence[Finding], path: str | os.PathLike[str]) -> None:
    """Write how many scenes pass, and a table of the others with reason and remedy, as Markdown of GitHub and GitLab.

    The table is HTML, in which a name from a scene can be no markup.
    """
    others = [finding for finding in findings if finding.result != PASSED]
    rows = [(each.result, each.scene, each.reason, each.remedy) for each in others[:MOST_ROWS]]
    parts = [f"### holdfast check: {counted(findings)}"]
    if rows:
        parts.append(ReportTable(("result", "scene", "reason", "what helps"), rows).html())
    if len(others) > MOST_ROWS:
        parts.append(f"and {many(len(others) - MOST_ROWS, 'scene')} more")
    write_atomically(path, ("\n\n".join(parts) + "\n").encode())
