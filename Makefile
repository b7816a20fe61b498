# Every target installs the packages that it needs into .venv. To work without make, see README.md.

PYTHON ?= python3
BIN := .venv/bin
# Jupyter refuses to run as root without this option. In most containers, you are root.
AS_ROOT := $(if $(filter 0,$(shell id -u)),--allow-root)

.PHONY: help lab demo grade site test proof colab mutants bench build check pictures constraints clean

help:
	@echo "make lab          open the notebooks in JupyterLab"
	@echo "make demo         grade a sample class in demo/"
	@echo "make grade        grade the class in submitted/"
	@echo "make site         write the course as a website to site/"
	@echo "make test         run the tests"
	@echo "make proof        run all tests with every seed, answer and attack"
	@echo "make colab        run the notebooks with Colab's package versions"
	@echo "make mutants      change the grading code in small ways; a test must detect each change"
	@echo "make bench        measure speed and memory, compared with other libraries"
	@echo "make build        write the notebooks and other generated files"
	@echo "make check        find notebooks that are out of date, lint errors and wrong formatting"
	@echo "make pictures     draw the previews of the lessons, and the film and pictures in the guides"
	@echo "make constraints  pin the versions of all packages that the requirements need"

# .venv/ready* are stamp files, which are newer than the requirements that were installed.
INSTALL := pip install --quiet --disable-pip-version-check

# The packages for students and graders.
.venv/ready: requirements.txt constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' || \
		{ echo "The course needs Python 3.11, 3.12 or 3.13. Name one: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -m venv .venv || \
		{ echo "This Python cannot create virtual environments. Install the missing package: sudo apt-get install python3-venv"; exit 1; }
	@echo "Installing the required packages into .venv. This takes a few minutes the first time."
	@$(BIN)/$(INSTALL) -r requirements.txt
	@touch $@

# Additional packages for the website.
.venv/ready-site: .venv/ready requirements-site.txt
	@echo "Installing the packages for the website into .venv."
	@$(BIN)/$(INSTALL) -r requirements-site.txt
	@touch $@

# Additional packages for development.
.venv/ready-dev: .venv/ready requirements-dev.txt requirements-3d.txt requirements-cluster.txt \
		requirements-formats.txt requirements-site.txt
	@echo "Installing the packages for the tests into .venv."
	@$(BIN)/$(INSTALL) -r requirements-dev.txt
	@touch $@

# Other libraries that the proof compares with the course. They take 1.8 GB.
.venv/ready-proof: .venv/ready-dev requirements-proof.txt requirements-viewers.txt
	@echo "Installing the packages for the proof into .venv."
	@$(BIN)/$(INSTALL) -r requirements-proof.txt
	@touch $@

# Authors need PYTHONPATH to run a lesson's .py, because the build writes the setup cell.
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

proof: .venv/ready-proof
	$(BIN)/python -m pytest -m "not colab" -o faulthandler_timeout=7200

# The first run installs Colab's package versions, which take 0.5 GB.
colab: .venv/ready-dev
	$(BIN)/python -m pytest -m colab -o faulthandler_timeout=7200

# cosmic-ray has a separate environment, because nothing else needs its dependencies.
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
	$(BIN)/python -m grader.course.films
	$(BIN)/python -m tests.class_pictures
	$(BIN)/python -m grader build

# Write one file for all versions of Python, with the newest packages that requirements*.txt allow.
# uv has a separate environment, because .venv/ready fails while requirements and constraints differ.
constraints:
	@$(PYTHON) -m venv .venv/uv && .venv/uv/bin/$(INSTALL) uv==0.13.9
	@cat requirements*.txt | grep -v '^-' | .venv/uv/bin/uv pip compile - --quiet --upgrade --no-config \
		--universal --python-version 3.11 --fork-strategy fewest --annotation-style line \
		--custom-compile-command "make constraints" --output-file constraints.txt

clean:
	rm -rf .venv demo
