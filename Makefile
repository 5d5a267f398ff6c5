# One command per intention. `run` and `test` make their own virtual environment first.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin

.PHONY: run test lint bench report docs clean
.DELETE_ON_ERROR:

run: $(VENV)/.run            ## the ice channel: server and mock CFD client over zenoh on loopback
	$(BIN)/comotion run channel --out out/channel

test: $(VENV)/.dev lint      ## everything that must hold
	$(BIN)/pytest -n 2 --dist worksteal

lint: $(VENV)/.dev           ## style, types, floors, spelling, dependencies
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/codespell
	$(BIN)/deptry .

bench: $(VENV)/.peers          ## figures that depend on the machine, each beside a peer or a limit; all run, then the verdict
	@status=0; for name in round_trip geometry contact_times events spheres field engines; do $(BIN)/python benchmarks/$$name.py || status=1; done; exit $$status

report: $(VENV)/.peers         ## error against run time beside other engines, extreme cases, what is left out; some ten minutes
	$(BIN)/comotion report --out docs/report

docs: $(VENV)/.docs          ## the pages as a site in out/docs; warnings, and so broken links, are errors
	$(BIN)/sphinx-build -W --keep-going -q -b html docs out/docs

$(VENV)/.docs: $(VENV)/.dev
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[docs]'
	touch $@

$(VENV)/.run: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[server,view]'
	touch $@

$(VENV)/.dev: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $@

$(VENV)/.peers: $(VENV)/.dev
	$(BIN)/pip install --quiet --constraint constraints.txt --editable '.[peers]'
	touch $@

clean:
	rm -rf $(VENV) out
