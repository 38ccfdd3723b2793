# make compare: install into .venv and run the main job; make test: the same for the tests.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: compare test lint slow docs pictures gallery tradeoff speed validation held examples study three clean site lowest dist

compare: $(VENV)/installed
	$(BIN)/renderer compare

# One process more than cores, because some tests wait for processes that they start. Compiled modules are kept,
# because the tests start the program about a hundred times.
test: export PYTHONDONTWRITEBYTECODE =
test: $(VENV)/tested
	$(BIN)/pytest -n $$($(BIN)/python -c "import os; print((os.cpu_count() or 1) + 1)") --dist worksteal \
		-m "not slow"

slow: $(VENV)/tested
	$(BIN)/pytest -m slow

lint: $(VENV)/tested
	$(BIN)/ruff check .

# Every picture, table and printed example of the pages, in about twenty minutes; the targets below
# make parts of it. The report's picture needs chromium. (validate --peers writes the table of peers.)
docs: pictures gallery tradeoff validation held examples

pictures: $(VENV)/tested
	$(BIN)/python docs/pictures.py
	$(BIN)/python docs/living_room.py
	$(BIN)/renderer report --quiet > /dev/null
	$(BIN)/python docs/report_picture.py
	$(BIN)/python docs/window_picture.py

validation: $(VENV)/installed
	$(BIN)/renderer validate --quiet > /dev/null
	$(BIN)/renderer validate --extremes --quiet > /dev/null
	$(BIN)/python docs/insert.py

# The numbers of untrusted inputs and surroundings that the tests try.
held: $(VENV)/tested
	$(BIN)/python docs/held.py

# The printed output of commands in the pages, the reference of the Python interface, and the notebook.
examples: $(VENV)/tested
	$(BIN)/python docs/pages.py
	$(BIN)/python docs/api.py
	$(BIN)/python docs/notebook.py

# Speed against accuracy in four rooms, beside Mitsuba and Radiance, into docs/tradeoff.md: about eight
# minutes on an idle machine. DRJIT_LIBLLVM_PATH names an LLVM for Mitsuba.
tradeoff: $(VENV)/installed
	$(BIN)/pip install --quiet --editable '.[peers]'
	for room in grey_room red_room furnished_room office; do \
		$(BIN)/renderer tradeoff $$room --quiet > /dev/null && \
		cp outputs/$${room}_tradeoff.png docs/pictures/tradeoff_$$room.png || exit 1; done
	$(BIN)/python docs/insert.py

# The tables of docs/performance.md, of one machine and one program: about half an hour on an idle machine.
# DRJIT_LIBLLVM_PATH names an LLVM for Mitsuba.
speed: $(VENV)/installed
	$(BIN)/pip install --quiet --editable '.[peers]'
	mkdir -p outputs
	$(BIN)/python benchmarks/trade.py > outputs/speed_trade.md
	$(BIN)/python benchmarks/performance.py > outputs/speed_parts.md
	$(BIN)/python benchmarks/speed.py 3 > outputs/speed_commands.md
	$(BIN)/python benchmarks/estimates.py > outputs/speed_forecasts.md
	$(BIN)/python benchmarks/peers.py picture > outputs/speed_pictures.md
	$(BIN)/python benchmarks/peers.py bands > outputs/speed_bands.md
	$(BIN)/python benchmarks/performance.py million > outputs/speed_million.md
	$(BIN)/python benchmarks/low_rank.py > outputs/speed_low_rank.md
	$(BIN)/python docs/insert.py

# The errors of RGB in many rooms, for docs/answer.md: about half an hour on two idle cores.
study: $(VENV)/installed
	$(BIN)/renderer study
	for figure in within rule models colour reds; do \
		cp outputs/study_$$figure.png docs/pictures/ || exit 1; done
	mkdir -p docs/data && cp outputs/study_readings.csv.gz docs/data/
	$(BIN)/python docs/insert.py

gallery: $(VENV)/installed
	$(BIN)/python docs/gallery.py
	$(BIN)/python docs/living_room.py
	$(BIN)/python docs/insert.py

# The parts of three.js that the report's page uses, as one file; needs npm. Only for a new version of three.js.
three:
	npm install --silent --no-save --prefix build/three three@0.187.0 esbuild@0.28.2
	cp renderer/pictures/report/three.entry.js build/three/
	build/three/node_modules/.bin/esbuild build/three/three.entry.js --bundle --minify --format=iife \
		--global-name=THREE --log-level=warning | gzip -9n > renderer/pictures/report/three.min.js.gz
	cp build/three/node_modules/three/LICENSE renderer/pictures/report/three.LICENSE.txt

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "renderer needs Python 3.11 or newer; try: make PYTHON=python3.12 $(MAKECMDGOALS)" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: pyproject.toml $(BIN)/python
	$(BIN)/pip install --quiet --editable .
	@touch $@

$(VENV)/tested: pyproject.toml $(BIN)/python
	$(BIN)/pip install --quiet --editable '.[test]'
	@touch $@ $(VENV)/installed

# The pages as one site that can be searched and read without a network: build/site/index.html.
site: $(VENV)/tested
	$(BIN)/pip install --quiet '.[site]'
	$(BIN)/python docs/api.py
	$(BIN)/python docs/build_site.py

# The tests against the lowest version of every dependency that pyproject.toml allows.
lowest: $(BIN)/python
	$(BIN)/pip install --quiet uv
	$(BIN)/uv venv --quiet --clear build/lowest
	$(BIN)/uv pip install --quiet --python build/lowest --resolution lowest-direct --editable '.[test]'
	build/lowest/bin/python -m pytest -m "not slow"

# The files to publish: a wheel of under 5 MB for every system, and the source.
dist: $(VENV)/tested
	rm -rf dist
	$(BIN)/python -m build --outdir dist
	$(BIN)/twine check --strict dist/*

clean:
	rm -rf $(VENV) build dist .pytest_cache .ruff_cache .hypothesis
