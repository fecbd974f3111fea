# Two commands do everything on a machine with Python 3.11 or later and make: `make demo` and `make test`.
# PYTHON names the interpreter; else it is the first of these that is recent enough
OLDEST := 3.11
PYTHON ?= $(shell for python in python3.11 python3 python3.14 python3.13 python3.12 python; do \
	"$$python" -c 'import sys; sys.exit(sys.version_info < tuple(map(int, "$(OLDEST)".split("."))))' 2>/dev/null \
	&& echo "$$python" && break; done)
VENV ?= .venv
BIN := $(VENV)/bin
CXX_GIVEN := $(filter-out default undefined,$(origin CXX))
OUT ?= out
NATIVE := $(wildcard src/holdfast/native/*.?pp src/holdfast/native/CMakeLists.txt)

.PHONY: demo test test-quick mutants test-slow test-referees test-kernels test-sanitized test-wheels wheels fuzz benchmark figures docs release-check lint clean

# On all cores, in the order of the files: neighbours share what they assembled. No threads beside the processes
PARALLEL := OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -n auto --dist worksteal

# An environment with what the demo needs; what tests and other targets need comes on top of it. It compiles the core, with
# a compiler from the package index where this machine has none
$(VENV)/.demo: pyproject.toml constraints.txt tools/build_backend.py $(NATIVE)
	@test -n "$(PYTHON)" || \
	 { echo "needs Python $(OLDEST) or later: install one, or name it, as in make $(MAKECMDGOALS) PYTHON=/path/to/python3"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	@test -n "$(or $(CXX_GIVEN),$(shell command -v c++ || command -v g++ || command -v clang++))" || \
	 echo "no C++ compiler here: ziglang from the package index compiles the core, which takes two to four minutes"
	@begun=$$(date +%s); \
	 $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[viewer]' || exit; \
	 echo "environment made and core compiled in $$(( $$(date +%s) - begun )) s"
	@touch $@

$(VENV)/.ready: $(VENV)/.demo
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

# What the tests compare with. compas_lmgc90 without what its metadata asks for: a viewer that the simulation does not use.
# It has no wheels for Python 3.14 yet; tests of what is missing skip and say so
$(VENV)/.bench: $(VENV)/.ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,bench,usd,ros,rerun,states]'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps -c constraints.txt \
	  'compas_lmgc90; python_version < "3.14"'
	@touch $@

demo: $(VENV)/.demo
	@mkdir -p $(OUT)
	@status=0; $(BIN)/holdfast assess table || status=$$?; \
	 if [ $$status -gt 1 ]; then exit $$status; fi; \
	 $(BIN)/holdfast map table --png $(OUT)/table.png --html $(OUT)/table.html
	@echo "open $(OUT)/table.png, or $(OUT)/table.html and turn it; next: $(BIN)/holdfast map tabletop --html $(OUT)/tabletop.html"

lint: $(VENV)/.ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

test: lint $(VENV)/.bench
	$(PARALLEL) -m "not slow and not referee"

# Deliberate breaks, each in a copy: whether the tests notice (tools/mutants.py; BREAKS="gap-sign ..." tries these alone)
BREAKS ?=
JOBS ?= 1
mutants: $(VENV)/.bench
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt cmake ninja nanobind
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python tools/mutants.py run --jobs $(JOBS) $(BREAKS)

# While working: closed forms, shapes, assemblies, what the conic solver and the checker of certificates say, and
# golden answers of every engine and question; under 90 s on two cores (CONTRIBUTING.md)
QUICK := assembly certificates closed_form conic geometry golden
test-quick: $(VENV)/.ready
	$(PARALLEL) -m "not slow and not referee" $(addprefix tests/,$(QUICK))

test-slow: $(VENV)/.bench
	$(PARALLEL) -m slow

test-referees: $(VENV)/.bench
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -m referee

# Linear algebra rounds otherwise on other processors: the numeric tests once for each of OpenBLAS's kernels that this
# processor can run, with one and with two threads
KERNELS ?= Prescott Haswell Zen SkylakeX
NUMERIC := applications cases closed_form conic elastic engines geometry golden properties queries
test-kernels: $(VENV)/.bench
	@for kernel in $(KERNELS); do for threads in 1 2; do \
	  echo "kernel $$kernel, $$threads threads"; \
	  OPENBLAS_CORETYPE=$$kernel OPENBLAS_NUM_THREADS=$$threads $(BIN)/pytest -n auto --dist worksteal \
	    -m "not slow and not referee" $(addprefix tests/,$(NUMERIC)) || exit 1; \
	done; done

# The compiled core, built to stop at wrong addresses and undefined behaviour, under the tests that use it most and the
# fuzzer's scenes and files. Needs a compiler of this machine: the preloaded library is its own
SANITIZED := $(OUT)/sanitized
CORE := elastic engines/trees geometry contacts settling closed_form drawing native golden fuzz/test_found.py
test-sanitized: $(VENV)/.bench
	@rm -rf $(SANITIZED); mkdir -p $(SANITIZED); cp -r src $(SANITIZED)/src; rm -f $(SANITIZED)/src/holdfast/native/*.so
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt cmake ninja nanobind
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/cmake -S $(SANITIZED)/src/holdfast/native -B $(SANITIZED)/build -G Ninja \
	  -DHOLDFAST_SANITIZE=ON -DPython_EXECUTABLE=$(abspath $(BIN))/python
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/cmake --build $(SANITIZED)/build
	export PYTHONPATH=$(abspath $(SANITIZED)/src):tests ASAN_OPTIONS=detect_leaks=0 PYTHONMALLOC=malloc OPENBLAS_NUM_THREADS=1 \
	  LD_PRELOAD="$$(c++ -print-file-name=libasan.so) $$(c++ -print-file-name=libubsan.so) $$(c++ -print-file-name=libstdc++.so)"; \
	$(BIN)/pytest -n auto --dist worksteal -m "not slow and not referee" $(addprefix tests/,$(CORE)) && \
	$(BIN)/python -m fuzz $(N) --seed $(SEED) --folder $(SANITIZED)/fuzz

# Wheel and sdist in a clean environment of every Python at hand; PYTHONS names more, separated by colons
test-wheels: $(VENV)/.ready
	$(BIN)/python tools/wheels.py $(OUT)/dist

# The wheels for Linux, for C libraries of 2018 and later, for every Python at hand, each tried in clean environments
wheels: $(VENV)/.ready
	$(BIN)/python tools/wheels.py $(OUT)/wheels --portable

# Random scenes, files and names: N more of them after those of earlier runs with this seed (state: $(OUT)/fuzz)
N ?= 1000
SEED ?= 0
fuzz: $(VENV)/.ready
	PYTHONPATH=tests $(BIN)/python -m fuzz $(N) --seed $(SEED) --folder $(OUT)/fuzz

benchmark: $(VENV)/.bench
	$(BIN)/python -m bench run all --compare

# Numbers and tables of README.md and docs/ from bench/results
figures: $(VENV)/.ready
	$(BIN)/python -m bench figures

# The site: pages, docstrings, examples as they run, saved benchmarks; nothing is asked of the network, any warning is an error
docs: $(VENV)/.ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,docs]'
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m sphinx --builder html --fail-on-warning --keep-going --quiet \
	  --doctree-dir $(OUT)/doctrees docs $(OUT)/site
	@echo "open $(OUT)/site/index.html"

# All that a release needs, in about half an hour, and then what is left to do by hand
release-check: test docs test-wheels
	$(BIN)/python tools/release_check.py $(OUT)

clean:
	rm -rf $(VENV) $(OUT) docs/benchmarks docs/files docs/gallery build dist src/holdfast/native/core.* .pytest_cache .mypy_cache .ruff_cache .hypothesis
