# Every target sets up what it needs, and does so once: `make demo` and `make test` work on a fresh clone.
# Written for GNU Make 3.81, which macOS ships. All paths are relative, so that the clone may lie anywhere.

VENV := .venv
PY := $(VENV)/bin/python
PIP_INSTALL := $(PY) -m pip install --quiet --disable-pip-version-check --constraint constraints.txt
NPM_RUN := npm --prefix web run --silent

# Stamps; they live in the environment, so that they vanish with it.
HAS_SIM := $(VENV)/.installed-sim
HAS_DEV := $(VENV)/.installed-dev
REQUIREMENTS := pyproject.toml constraints.txt

# Options for the program or for pytest, as in: make demo ARGS="--vehicles 5"
ARGS ?=
# Python keeps what it compiles, here too where the environment says otherwise: tests start many processes.
export PYTHONDONTWRITEBYTECODE :=
# Processes that run tests side by side; auto is two more than cores, see tests/schedule.py.
WORKERS ?= auto
# Repetitions of the whole suite by make soak-test.
RUNS ?= 10
# Missions of make test-faults, and the seed of a single one.
MISSIONS ?= 500
SEED ?=
PYTEST := $(PY) -m pytest
PARALLEL = -n $(WORKERS) --durations=25 --durations-min=1

.DEFAULT_GOAL := help
.PHONY: help demo check test test-slow test-faults test-sitl soak-test bench lint web kernels web-check wheel constraints clean
.NOTPARALLEL:

help: ## Show this help
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "make %-12s %s\n", $$1, $$2}' Makefile

demo: web kernels $(HAS_SIM) ## Fly the simulated mission with the dashboard; ARGS="..." for aos-gcs demo
	$(VENV)/bin/aos-gcs demo $(ARGS)

# Checks style and types, which one core does, beside the command $(1), and reports them after it.
define beside_lint
	@mkdir -p .make; \
	$(MAKE) --no-print-directory lint >.make/lint.log 2>&1 & lint=$$!; trap "kill $$lint 2>/dev/null" INT TERM; \
	$(1); status=$$?; \
	wait $$lint; style=$$?; echo; cat .make/lint.log; test $$status -eq 0 -a $$style -eq 0
endef

# These tests wait for nothing: more processes than cores would only import everything once more.
check: WORKERS = $(shell getconf _NPROCESSORS_ONLN)
check: kernels $(HAS_DEV) ## Check style and types, run unit and contract tests without waiting: before every commit; ARGS="..." for pytest
	$(call beside_lint,$(PYTEST) $(PARALLEL) -m "not slow and not sitl and not realtime" tests/unit tests/contract $(ARGS))

test: kernels $(HAS_DEV) ## Check and test everything but slow and sitl; ARGS="..." for pytest
	$(call beside_lint,$(MAKE) --no-print-directory web-check)
	$(PYTEST) $(PARALLEL) $(ARGS)

test-slow: export HYPOTHESIS_PROFILE := thorough
test-slow: web kernels $(HAS_DEV) ## Run the slow tests, and all properties with ten times as many examples
	$(PYTEST) $(PARALLEL) -m "(slow or hypothesis) and not sitl" $(ARGS)

test-faults: kernels $(HAS_DEV) ## Fly MISSIONS (500) random missions with random faults; SEED=123 repeats one
	$(PY) -m tests.campaign --missions $(MISSIONS) $(if $(SEED),--seed $(SEED)) $(ARGS)

test-sitl: web kernels $(HAS_DEV) ## Run the tests against real autopilots in the loop
	$(PYTEST) -m sitl $(ARGS)

soak-test: web kernels $(HAS_DEV) ## Run all tests RUNS times (10) beside two busy processes and report what failed
	$(PY) scripts/soak_test.py --runs $(RUNS) -- $(PYTEST) $(PARALLEL) $(ARGS)

bench: web kernels $(HAS_DEV) ## Measure, and write docs/performance.md; ARGS="imaging render" for some of tests/benchmarks
	$(PY) tests/benchmarks/performance.py $(ARGS)

lint: $(HAS_DEV) ## Check style and types of the Python code
	$(VENV)/bin/ruff check
	$(VENV)/bin/ruff format --check
	$(VENV)/bin/mypy

web: $(PY) ## Build the dashboard where its sources have changed
	@$(PY) scripts/build_dashboard.py

kernels: $(PY) ## Compile the kernels of imaging where their sources have changed and there is a C compiler
	@$(PY) scripts/build_kernels.py

web-check: web $(HAS_DEV) ## Check and test the dashboard, and that its types fit the API
	@$(PY) scripts/build_dashboard.py --with-tools
	PYTHON="$$PWD/$(PY)" $(NPM_RUN) check:schema
	$(NPM_RUN) check

wheel: web ## Build a wheel with the dashboard into dist/
	$(PY) -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .

constraints: ## Renew constraints.txt: the newest versions that pyproject.toml allows
	sh scripts/renew_constraints.sh

clean: ## Remove everything that make has made; missions stay
	rm -rf $(VENV) .make build dist aos_gcs/api/static aos_gcs/imaging/native/*.so web/node_modules
	rm -rf .soak .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(PY):
	@sh scripts/make_venv.sh $(VENV)

$(HAS_SIM): $(PY) $(REQUIREMENTS)
	$(PIP_INSTALL) --editable ".[sim]"
	@touch $@

$(HAS_DEV): $(PY) $(REQUIREMENTS)
	$(PIP_INSTALL) --editable ".[dev]"
	@touch $(HAS_SIM) $@
