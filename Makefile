# make demo · make test: each sets up what it needs, once, in .venv and (system libraries) with apt.
# make docs: the documentation as a site, in build/site
# make check · make format · make lock · make clean

PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: demo test tests docs check format lock clean

demo: .venv/.demo-installed
	$(BIN)/labrig demo

# Small matrices: more threads would only wait for each other where the tests share a computer.
export OMP_NUM_THREADS ?= 1

# Memory that is freed stays with the process: asking for it anew takes a sixth of a diagnosis (glibc; others ignore it).
export MALLOC_MMAP_MAX_ ?= 0
export MALLOC_TRIM_THRESHOLD_ ?= 100000000000

# What one process compiles is there for the others, also where the environment forbids to keep it.
unexport PYTHONDONTWRITEBYTECODE

# Two workers more than there are cores: many tests wait for devices, servers and pages.
WORKERS ?= $(shell $(PYTHON) -c "import os; print(min(4, (os.cpu_count() or 1) + 2))")

# The checks keep one core busy for a while: they run beside the tests.
test: .venv/.all-installed .venv/.system-libraries
	@$(MAKE) --no-print-directory --jobs 2 --keep-going check tests

tests:
	@$(BIN)/python tests/compiled.py
	$(BIN)/python -m pytest --numprocesses $(WORKERS) --dist loadfile --no-loadscope-reorder

docs: .venv/.all-installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict
	@echo "build/site/index.html; with search: $(BIN)/python -m http.server --bind 127.0.0.1 -d build/site"

check: .venv/.all-installed
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	NODE_OPTIONS=--max-semi-space-size=128 $(BIN)/pyright  # a tenth less time: its collector has more room
	$(BIN)/lint-imports

format: .venv/.all-installed
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

# Versions are pinned by requirements.lock: the demo takes from it what labrig itself needs, the tests all of it.
.venv/.demo-installed: .venv/.made requirements.lock pyproject.toml
	$(PIP) install --constraint requirements.lock hatchling editables
	$(PIP) install --constraint requirements.lock --no-build-isolation --editable '.[workbench]'
	@touch $@

.venv/.all-installed: .venv/.demo-installed
	$(PIP) install --requirement requirements.lock
	@touch $@

.venv/.made:
	@bash .ci/system-libraries python $(PYTHON)
	$(PYTHON) -m venv .venv
	@touch $@

.venv/.system-libraries: .ci/system-libraries .venv/.made
	@bash .ci/system-libraries viewer
	@bash .ci/system-libraries scan
	@bash .ci/system-libraries browser
	@touch $@

# What a fresh resolution of pyproject.toml gives today; only run this to move to newer versions.
lock:
	$(PYTHON) -m venv --clear build/lock
	build/lock/bin/python -m pip install --quiet '.[dev]'
	build/lock/bin/python -m pip freeze --exclude labrig | sed 's/+cpu$$//' > requirements.lock.new
	mv requirements.lock.new requirements.lock
	rm -rf build/lock

clean:
	rm -rf .venv build dist .pytest_cache .ruff_cache .hypothesis .import_linter_cache
