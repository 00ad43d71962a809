# Two commands set up everything: `make gaps` (the main job) and `make test`.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
SUITE ?= table1
CHROMIUM := /usr/bin/chromium
FOLDERS := benchmark formulations heuristics instances views

.PHONY: gaps lessons live test docs recorded typing-links clean

gaps: $(VENV)/installed
	$(BIN)/cutgap gaps $(SUITE) --resume

lessons: $(VENV)/lessons-installed
	$(BIN)/python docs/lessons/notebooks.py
	$(BIN)/jupyter lab docs/lessons

live: $(VENV)/installed
	$(BIN)/marimo run docs/live/two_heads.py

test: $(VENV)/installed typing-links $(CHROMIUM)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pytest -n auto

# Executes every page, on all cores; a warning, also of a link that leads nowhere, is an error.
docs: $(VENV)/installed
	$(BIN)/sphinx-build -W --keep-going -q -j auto -b html docs build/docs

# The runs behind the benchmark page.
recorded: $(VENV)/installed
	$(BIN)/python docs/recorded/record.py

$(VENV)/lessons-installed: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --editable '.[lessons]'
	touch $@

# Runs again only when the dependencies change; the install is editable. What is installed is compiled afterwards,
# on all cores: pip takes one. Some packages hold files for other versions of Python, which do not compile.
$(VENV)/installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --editable '.[test,cluster,live,docs]'
	$(BIN)/python -m compileall -qq -j 0 $(VENV)/lib || true
	touch $@

# Pages are tested in a browser; Debian's, which needs no download of its own.
$(CHROMIUM):
	apt-get update -qq
	apt-get install -y -qq --no-install-recommends chromium

# mypy does not follow setuptools' folder mapping, so it reads the tree through links.
typing-links:
	mkdir -p build/typing/cutgap
	for folder in $(FOLDERS); do ln -sfn ../../../$$folder build/typing/cutgap/$$folder; done

clean:
	rm -rf $(VENV) build *.egg-info
