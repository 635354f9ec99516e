# Each target makes its own .venv on a machine with Python >= 3.11, pip and venv. `make help` lists them.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: help walk test fuzz soak hour check clean

help:
	@echo "make walk    install, walk the hexapod in simulation, leave walk.gif"
	@echo "make test    install and run all tests"
	@echo "make fuzz    two million garbled inputs to all that takes bytes from a wire; under half an hour"
	@echo "make soak    200 random command sequences a robot, on two processes; about half an hour"
	@echo "make hour    an hour of walking in lock-step, faults coming and going; about ten minutes"
	@echo "make check   lint and type check"
	@echo "make clean   remove .venv and what the tools leave behind"

walk: .venv/runtime
	$(BIN)/robotwalk walk hexapod --speed 0.1 --duration 10 --gif walk.gif

# One worker more than processors: tests that walk in real time mostly wait. Those have a worker of their own, and so
# has each module whose tests share what is dear (`xdist_group`).
test: .venv/dev
	$(BIN)/python -m pytest -n $$(($$(nproc) + 1)) --dist loadgroup

fuzz: .venv/dev
	$(BIN)/python -m tests.fuzz 100000

soak: .venv/dev
	$(BIN)/python -m tests.walk.soak --jobs 2

hour: .venv/dev
	$(BIN)/python -m tests.walk.hour

check: .venv/dev
	$(BIN)/ruff check .
	$(BIN)/mypy

.venv/bin/python:
	$(PYTHON) -m venv .venv

# Groups of development dependencies need pip 25.1; a new venv may have an older one.
.venv/runtime: .venv/bin/python pyproject.toml
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

.venv/dev: .venv/runtime
	$(BIN)/python -m pip install --quiet --group dev
	@touch $@

clean:
	rm -rf .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis dist walk.gif
