# Two commands do everything on a machine with Python 3.11 and make: `make demo` and `make test`.
PYTHON ?= python3.11
VENV ?= .venv
BIN := $(VENV)/bin
OUT ?= out
# Where compiled loops are kept (src/holdfast/base/compiled.py)
COMPILED := $(or $(HOLDFAST_CACHE_DIR),$(or $(XDG_CACHE_HOME),$(HOME)/.cache)/holdfast)

.PHONY: demo test test-slow test-referees benchmark figures lint clean

# On all cores, in the order of the files: neighbours share what they assembled. No threads beside the processes
PARALLEL := OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -n auto --dist worksteal

$(VENV)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@touch $@

# What the tests compare with. compas_lmgc90 without what its metadata asks for: a viewer that the simulation does not use
$(VENV)/.simulators: $(VENV)/.ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev,simulators]'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps -c constraints.txt compas_lmgc90
	@touch $@

demo: $(VENV)/.ready
	@mkdir -p $(OUT)
	@status=0; $(BIN)/holdfast assess table || status=$$?; \
	 if [ $$status -gt 1 ]; then exit $$status; fi; \
	 $(BIN)/holdfast map table --png $(OUT)/table.png --html $(OUT)/table.html

lint: $(VENV)/.ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

test: lint $(VENV)/.simulators
	$(PARALLEL) -m "not slow and not referee"

test-slow: $(VENV)/.simulators
	$(PARALLEL) -m slow

test-referees: $(VENV)/.simulators
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -m referee

benchmark: $(VENV)/.simulators
	$(BIN)/holdfast benchmark all --compare

# Numbers and tables of README.md and docs/ from benchmarks/results
figures: $(VENV)/.ready
	$(BIN)/python tools/figures.py write

clean:
	rm -rf $(VENV) $(OUT) build dist src/*.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	rm -rf $(COMPILED)/compiled-*
