# Everything a newcomer needs; python3 (3.11 or later) with pip and make are enough.

PYTHON  ?= python3
WORKERS ?= 2
MACHINE ?= examples/machines/discoidal.toml
NAME    := $(basename $(notdir $(MACHINE)))
DEMO    := out/demo
BIN     := .venv/bin
PART    := $(BIN)/python -m tools.parts run
PIP     := $(BIN)/python -m pip install --quiet --quiet --disable-pip-version-check
export MPLBACKEND := Agg
export OPENBLAS_NUM_THREADS := 1  # the matrices are small; threads only get in each other's way

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo app app-test test test-slow test-ross test-times bench reproduce docs lint wheel clean

help:  ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' $(firstword $(MAKEFILE_LIST))

demo: .venv/.core  ## run a machine from its file to pictures and a film
	@mkdir -p $(DEMO)
	$(BIN)/autobalancer check $(MACHINE)
	$(BIN)/autobalancer simulate $(MACHINE) --out $(DEMO)/$(NAME).nc
	$(BIN)/autobalancer plot $(DEMO)/$(NAME).nc --out $(DEMO)
	$(BIN)/autobalancer animate $(DEMO)/$(NAME).nc --out $(DEMO)/$(NAME).mp4
	$(BIN)/autobalancer animate $(DEMO)/$(NAME).nc --out $(DEMO)/$(NAME).gif
	@echo
	@echo "The result, the pictures and the film are in $(DEMO):"
	@ls $(DEMO) | sed 's/^/  /'

app: .venv/.app  ## open the bench in a browser
	$(BIN)/autobalancer app

app-test: build/.kernels  ## try the bench in a real browser (Chromium)
	@tools/find_chromium || { echo "no Chromium is here and none could be installed: the tests of the page are skipped"; exit 0; }; \
	$(PART) app-test $(BIN)/python -m pytest tests/browser -m browser $(if $(CI),--reruns 1 -r R)

test: build/.kernels  ## run the tests, in a few minutes; in CI also the long ones
	$(PART) test $(BIN)/python -m pytest -n $(WORKERS) $(if $(CI),,-m "not slow") --ignore tests/browser

test-slow: build/.kernels  ## run the long tests that `make test` leaves out
	$(BIN)/python -m pytest -n $(WORKERS) -m slow $$(grep -l mark.slow tests/*.py)

test-ross: .venv-ross/.ready  ## run the tests against ROSS, in an environment of its own
	.venv-ross/bin/python -m pytest tests/test_shaft_ross.py tests/test_balancer_in_ross.py

test-times: .venv/.dev  ## show what the tests took, and fail where a part is over its share
	@$(BIN)/python -m tools.parts

build/.kernels: .venv/.dev $(shell find src/autobalancer/kernels -name '*.py')
	$(PART) kernels $(BIN)/python -m tests.references.compiled $(WORKERS)
	@touch $@

bench: .venv/.dev  ## measure against other software, or ONLY=start; writes build/benchmarks.json
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m benchmarks $(if $(ONLY),--only $(ONLY))

reproduce: .venv/.core  ## redo published results; writes build/reproductions.json
	$(BIN)/python -m reproductions

docs: .venv/.dev  ## build the documentation in docs/_build
	$(BIN)/python -m sphinx -b html -W --keep-going --quiet docs docs/_build
	@echo "open docs/_build/index.html"

lint: .venv/.dev  ## style, types and the order of the layers
	@$(PART) lint sh -c '$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy $(if $(CI),--cache-dir=/dev/null) && $(BIN)/lint-imports'

wheel: .venv/.dev  ## build a wheel with compiled kernels in dist, and prove that nothing compiles from it
	$(BIN)/python -m tools.wheel

clean:  ## remove what was built; .venv stays
	rm -rf build dist out docs/_build docs/gallery docs/reference/generated docs/sg_execution_times.rst
	rm -rf .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .numba_cache
	find . -name .venv -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

# The environment: the package alone for users (.core), and with all tools for developers (.dev).

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed; try make PYTHON=python3.12")'
	@$(PYTHON) -m venv --clear .venv

.venv-ross/.ready: pyproject.toml
	@echo "installing the package and ROSS in .venv-ross ..."
	@$(PYTHON) -m venv --clear .venv-ross
	@.venv-ross/bin/python -m pip install --quiet --disable-pip-version-check -e '.[ross]' pytest pytest-xdist
	@touch $@

.venv/.core: pyproject.toml | $(BIN)/python
	@echo "installing the package in .venv ..."
	@$(PIP) --editable '.[film]'
	@touch $@

.venv/.app: pyproject.toml | $(BIN)/python
	@echo "installing the package and its page in .venv ..."
	@$(PIP) --editable '.[app]'
	@touch $@

.venv/.dev: pyproject.toml | $(BIN)/python
	@echo "installing the package and its tools in .venv ..."
	@$(PIP) --editable '.[dev]'
	@touch .venv/.core .venv/.app $@
