# make run    set up a fresh machine and bring the robot up   (ARGS="--headless --duration 5")
# make test   every test          make check   format, lint, types, layers, unit tests
# make test-lerobot  the tests of LeRobot, in an environment of its own
# make bench  the measurements    make clean   remove what was made
# make web    the panel's page    make web-dev the page from its sources, beside a bringup
# make docs   the documentation, as a site in build/docs

VENV ?= .venv
ARGS ?=
BIN  := $(VENV)/bin
RUN  := $(VENV)/.stamp-run
DEV  := $(VENV)/.stamp-dev
PAGE := src/tool0/panel/static/.stamp
CHECKED_PAGE := $(VENV)/.stamp-page-checked
WEB  := $(BIN)/python tools/web.py
BROWSER := $(VENV)/.stamp-browser
KERNEL  := src/tool0/kernel/_kernel.so
GAZEBO  := $(VENV)/.stamp-gazebo
ROS1    := $(VENV)/.stamp-ros1
ROS2    := $(VENV)/.stamp-ros2
GL      := $(VENV)/.stamp-gl
LEROBOT := .venv-lerobot/.stamp
LEROBOT_PYTHON ?= python3.12
ZSH     := $(VENV)/.stamp-zsh
# What `make test` may not do without; other things that are absent skip their tests.
TOOL0_REQUIRE ?= browser
# Tests that no load disturbs run in one process more than there are processors, as some
# wait for other programs; in 4 at most.
WORKERS ?= $(shell n=$$(getconf _NPROCESSORS_ONLN); echo $$((n < 4 ? n + 1 : 4)))
PYTEST  := $(BIN)/python -m pytest
AT_ONCE := $(PYTEST) --numprocesses=$(WORKERS)
STURDY  := tests/unit tests/conformance
# Those of other programs, whole files at a time: they share a Gazebo or a ROS.
PATIENT := tests/documentation tests/gazebo tests/ros1 tests/ros2 tests/ur tests/fuzz $(wildcard tests/test_*.py)
# Those that measure wall time, or hold what is sent to a rate: one at a time.
ALONE   := $(addprefix tests/clients/test_,panel_jog.py panel_obstacles.py real_arm_tutorial.py real_robot.py real_robot_link.py real_robot_ros.py \
           browser_real_robot.py stop_under_flood.py ur_process_delayed.py ur_rtde.py ur_rtde_safety.py urscript_search.py)
# Those of browsers, which draw with the processor: two files at a time.
TWO_FILES := $(PYTEST) --numprocesses=2
CLIENTS := $(filter-out $(ALONE),$(wildcard tests/clients/test_*.py))

# What runs in real time fails if the machine stands still for a second.  Such a test is
# tried again, and listed as RERUN (tests/rigs/standstill.py); of the tests with other
# programs, any failed test is tried once more.
RERUNS := -rR --rerun-show-tracebacks
AGAIN := --reruns=1 $(RERUNS)

# Programs that the tests start load compiled modules.
unexport PYTHONDONTWRITEBYTECODE

# NumPy's threads of several processes would wait for each other.
unit-python test: export OPENBLAS_NUM_THREADS := 1

.DEFAULT_GOAL := help
.PHONY: help run setup dev check lint lint-python lint-web format unit unit-python unit-web
.PHONY: test test-lerobot bench docs web web-dev clean

help:
	@sed -n 's/^# //p' Makefile

run: setup
	@$(BIN)/tool0 bringup $(ARGS)

setup: $(RUN) $(PAGE) $(KERNEL)

dev: $(DEV)

# First what uses one processor, side by side, then the tests of Python, which use all:
# each command shows its output when it ends, and pytest its progress.  The page is
# checked again only when its sources or the messages that it reads have changed.
check: $(DEV)
	@$(MAKE) --no-print-directory --jobs=2 --output-sync=line lint-python $(CHECKED_PAGE)
	@$(MAKE) --no-print-directory unit-python

lint: lint-python lint-web

lint-python: $(DEV)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python tools/coupling.py

lint-web: $(DEV)
	$(WEB) run check:static

$(CHECKED_PAGE): $(PAGE) $(wildcard src/tool0/protocol/*.py src/tool0/panel/*.py) | $(DEV)
	@$(MAKE) --no-print-directory lint-web unit-web
	@touch $@

# A warning is an error: a broken link, a page in no table of contents, a bad docstring.
docs: $(DEV)
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs build/docs

format: $(DEV)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(WEB) run format

unit: unit-python unit-web

unit-python: $(DEV) $(KERNEL)
	$(AT_ONCE) tests/unit -m 'not slow' $(ARGS)

unit-web: $(DEV)
	$(WEB) run test

test: $(DEV) $(PAGE) $(KERNEL) $(BROWSER) $(GAZEBO) $(ROS1) $(ROS2) $(GL) $(ZSH) unit-web
	export TOOL0_REQUIRE='$(TOOL0_REQUIRE)'; failed=; chosen=; \
	run() { "$$@" $(ARGS); case $$? in 0) chosen=1;; 5) ;; *) failed=1;; esac; }; \
	run $(AT_ONCE) $(RERUNS) $(STURDY); \
	run $(AT_ONCE) $(AGAIN) $(PATIENT); \
	run $(TWO_FILES) $(AGAIN) $(CLIENTS); \
	run $(PYTEST) $(AGAIN) $(patsubst %,--ignore=%,$(STURDY) $(PATIENT) $(CLIENTS)); \
	[ -z "$$failed" ] && [ "$$chosen" ]  # status 5: ARGS chose none of them

# LeRobot with its PyTorch takes 7 GB and another Python, so it is no part of `make test`.
test-lerobot: $(LEROBOT) $(KERNEL)
	$(dir $(LEROBOT))bin/python -m pytest tests/with_lerobot $(ARGS)

bench: $(DEV) $(KERNEL)
	$(BIN)/python benchmarks/run.py $(ARGS)

web: $(PAGE)

web-dev: $(RUN)
	$(WEB) run dev

clean:
	rm -rf $(VENV) build dist $(KERNEL) src/tool0/panel/static web/node_modules .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis

# The stamps: what they depend on is newer, so install again; otherwise do nothing.
$(RUN): pyproject.toml tools/setup-venv
	@echo 'setting up $(VENV), and the panel with it: about a minute' >&2
	@tools/setup-venv $(VENV)
	$(BIN)/python -m pip install --disable-pip-version-check --editable .
	@touch $@

$(LEROBOT): pyproject.toml plugins/lerobot_robot_tool0/pyproject.toml
	$(LEROBOT_PYTHON) -m venv $(dir $@)
	$(dir $@)bin/python -m pip install --quiet --disable-pip-version-check 'lerobot[training,async]>=0.6,<0.7' \
		--editable '.[collect,video]' --editable plugins/lerobot_robot_tool0 hypothesis pytest pytest-rerunfailures pytest-timeout pytest-xdist
	@touch $@

# `pip install --group` came with pip 25.1; a distribution's pip is older.
$(DEV): $(RUN)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'pip>=25.1'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --group dev
	@touch $@

# The install above makes the page, too; after that it is made when its sources change.
$(PAGE): $(filter-out %/protocol.ts,$(shell find web -name node_modules -prune -o -type f -print)) | $(RUN)
	$(WEB) build
	@touch $@

# So is the kernel; without a compiler, and without PyPI's, control runs in Python.
$(KERNEL): $(wildcard src/tool0/kernel/*.[ch]) src/tool0/kernel/build.py | $(RUN)
	@if $(BIN)/python -m tool0.kernel.build --install-compiler; then touch $@; \
	else echo 'setup: everything works without it, more slowly' >&2; fi

$(BROWSER): tools/setup-browser | $(RUN)
	@tools/setup-browser
	@touch $@

$(GL): tools/setup-gl | $(RUN)
	@if tools/setup-gl $(VENV); then touch $@; \
	else echo 'setup: no OpenGL here; the tests that draw pictures will be skipped' >&2; fi

$(ZSH): tools/apt-install | $(RUN)
	@if command -v zsh >/dev/null || tools/apt-install zsh; then touch $@; \
	else echo 'setup: no zsh here; the tests of its completion will be skipped' >&2; fi

# A quarter of a gigabyte from the network: without one, the tests that need Gazebo skip.
$(GAZEBO): tools/setup-gazebo | $(RUN)
	@if tools/setup-gazebo $(VENV); then touch $@; \
	else echo 'setup: no Gazebo here; the tests that need it will be skipped' >&2; fi

# From the distribution's packages, RViz with them; some distributions have none.
$(ROS1): tools/setup-ros1 src/tool0/installation/ros1/packages.py | $(RUN)
	@if tools/setup-ros1 $(VENV); then touch $@; \
	else echo 'setup: no ROS 1 here; the tests that need it will be skipped' >&2; fi

# PyPI's wheels, and message packages that are compiled; only for x86-64.
$(ROS2): tools/setup-ros2 src/tool0/installation/ros2/install.py src/tool0/installation/ros2/generate.py $(shell find src/tool0/installation/ros2/definitions -type f) | $(RUN)
	@if tools/setup-ros2 $(VENV); then touch $@; \
	else echo 'setup: no ROS 2 here; the tests that need it will be skipped' >&2; fi
