# Every target sets up what it needs in .venv by itself. Without make: see README.md.

PYTHON ?= python3
BIN := .venv/bin
# Jupyter refuses to run as root, which is who you are in most containers.
AS_ROOT := $(if $(filter 0,$(shell id -u)),--allow-root)

.PHONY: help lab demo grade site test proof colab mutants bench build check pictures constraints clean

help:
	@echo "make lab      open the notebooks in JupyterLab"
	@echo "make demo     grade a sample class in demo/"
	@echo "make grade    grade the class in submitted/"
	@echo "make site     write the course as pages for a web server, in site/"
	@echo "make test     run the tests"
	@echo "make proof    run all of them, with every seed, answer and attack"
	@echo "make colab    run the notebooks with Colab's versions"
	@echo "make mutants  change the judge's rules one by one: do the tests notice?"
	@echo "make bench    measure speed and memory against other libraries"
	@echo "make build    write the notebooks from their sources"
	@echo "make check    are the notebooks fresh, is the code clean?"
	@echo "make pictures draw the pictures of the README and the lessons"
	@echo "make constraints  pin anew what the requirements need in turn"

# A stamp is newer than its requirements when they are installed.
INSTALL := pip install --quiet --disable-pip-version-check

# What a student and a grader need.
.venv/ready: requirements.txt constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' || \
		{ echo "This needs Python 3.11, 3.12 or 3.13. Name one: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -m venv .venv || \
		{ echo "Python cannot make virtual environments. Install the missing part: sudo apt-get install python3-venv"; exit 1; }
	@echo "Installing what the course needs into .venv; this takes a minute or two the first time."
	@$(BIN)/$(INSTALL) -r requirements.txt
	@touch $@

# What the pages of the course need besides.
.venv/ready-site: .venv/ready requirements-site.txt
	@echo "Installing what writes pages into .venv, too."
	@$(BIN)/$(INSTALL) -r requirements-site.txt
	@touch $@

# What development needs besides.
.venv/ready-dev: .venv/ready requirements-dev.txt requirements-3d.txt requirements-cluster.txt requirements-site.txt
	@echo "Installing what the tests need into .venv, too."
	@$(BIN)/$(INSTALL) -r requirements-dev.txt
	@touch $@

# PYTHONPATH is for authors: a lesson's .py has no setup cell before it is built.
lab: .venv/ready
	PYTHONPATH="$(CURDIR)" $(BIN)/jupyter lab --ServerApp.root_dir=. --LabApp.default_url=/lab/tree/notebooks $(AS_ROOT)

demo: .venv/ready
	$(BIN)/python -m grader demo

grade: .venv/ready
	$(BIN)/python -m grader grade

site: .venv/ready-site
	$(BIN)/python -m grader site

test: .venv/ready-dev
	$(BIN)/python -m pytest -m "not proof and not colab"

proof: .venv/ready-dev
	$(BIN)/python -m pytest -m "not colab" -o faulthandler_timeout=1800

# Installs half a gigabyte of Colab's versions, once.
colab: .venv/ready-dev
	$(BIN)/python -m pytest -m colab -o faulthandler_timeout=1800

# cosmic-ray stands apart: none of ours needs what it needs.
mutants: .venv/ready-dev
	@$(BIN)/python -m venv .venv/cosmic-ray && .venv/cosmic-ray/bin/$(INSTALL) cosmic-ray==8.7.0
	$(BIN)/python tests/mutants.py

bench: .venv/ready-dev
	@for file in tests/benchmarks/bench_*.py; do echo "== $$file"; PYTHONPATH=. $(BIN)/python $$file || exit 1; done

build: .venv/ready
	$(BIN)/python -m grader build

check: .venv/ready-dev
	$(BIN)/python -m grader build --check
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

pictures: .venv/ready-dev
	$(BIN)/python -m grader.course.previews
	PYTHONPATH=. $(BIN)/python solutions/stage4_realtime/12_streaming_obstacles/hero.py
	$(BIN)/python -m grader build

# One file for every Python: the newest versions that go with what requirements*.txt name.
# uv stands apart, as .venv/ready cannot be made while requirements and constraints differ.
constraints:
	@$(PYTHON) -m venv .venv/uv && .venv/uv/bin/$(INSTALL) uv==0.13.9
	@cat requirements*.txt | grep -v '^-' | .venv/uv/bin/uv pip compile - --quiet --upgrade --no-config \
		--universal --python-version 3.11 --fork-strategy fewest --annotation-style line \
		--custom-compile-command "make constraints" --output-file constraints.txt

clean:
	rm -rf .venv demo
