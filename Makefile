# Every target sets up by itself what it lacks (.ci/setup). Without make: bash .ci/setup.
.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help report compare test test-all images install trouble lint strict archive docs bench
.PHONY: figures fuzz
.PHONY: validation setup clean tables maps machine mutants wheel wheel-test

DECK ?= data/thesis.deck
comma := ,

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-9s %s\n", $$1, $$2 }' Makefile

report: ## print the report of the original program (DECK=other.deck for another deck)
	@bash .ci/setup build
	@exe=$$(bash .ci/build release) && "$$exe" "$(DECK)"

compare: ## Tables VI and VIIA to C, number by number: as scanned, as taken, as printed here
	@bash .ci/setup build test
	@exe=$$(bash .ci/build release) && .venv/bin/python test/support/side_by_side.py "$$exe"

test: ## unit tests in the strict build, then the tests marked `fast`
	@bash .ci/setup build
	@bash .ci/test -m fast

test-all: ## the same with all tests, some in a browser
	@bash .ci/setup build page
	@bash .ci/test

wheel: ## a wheel that needs no compiler and no other library, and the sources, in dist/
	@bash .ci/setup build wheel
	@bash .ci/wheel

wheel-test: ## wheel and sources in empty environments
	@bash .ci/setup build test wheel
	@bash .ci/wheel test

install: ## program, libraries, header, completion and manual page under PREFIX (~/.local)
	@bash .ci/setup build
	@PATH="$$PWD/.venv/bin:$$PATH" python3 python/build_backend.py "$(or $(PREFIX),$(HOME)/.local)"

images: ## a run of two images over MPI against one of one
	@bash .ci/setup build test images
	@bash .ci/trouble images

trouble: ## all tests again in builds that look for trouble, and a second compiler
	@bash .ci/setup build test trouble
	@bash .ci/trouble $(BUILD)

lint: ## check the style of the sources
	@bash .ci/setup lint
	@bash .ci/lint

strict: ## build everything with all warnings as errors and all checks on
	@bash .ci/setup build
	@bash .ci/build strict

archive: ## rewrite reference_output/ (on purpose only, see CONTRIBUTING.md)
	@bash .ci/setup build
	@bash .ci/archive

docs: ## the site in build/site: pages with search, Python API, Fortran API
	@bash .ci/setup docs
	@bash .ci/site

ifeq ($(PART),accuracy)
bench:
	@bash .ci/setup build test
	@.venv/bin/python test/bench/accuracy_costs.py $(if $(SAVE),--save,--seconds 40)
	@.venv/bin/python test/bench/accuracy_promises.py $(if $(SAVE),--save,--asperities 12 --maps 10)
else ifeq ($(PART),maps)
bench:
	@bash .ci/setup build test
	@.venv/bin/python test/bench/map_area.py $(if $(SAVE),--save,--realisations 3)
	@.venv/bin/python test/bench/pixel_estimates.py $(if $(SAVE),--seeds 16 --save,--seeds 1)
else ifneq ($(PART),)
bench:
	@bash .ci/setup build test
	@.venv/bin/python test/bench/run_bench.py --parts $(subst scale,phases$(comma)threads,$(PART)) \
	  $(if $(MOST),--most $(MOST)) $(if $(BESIDE),--beside $(BESIDE))
else
bench: ## time and memory; SAVE=1 keeps them, SMALL=1; PART=maps|interaction|accuracy|scale
	@bash .ci/setup build test
	@.venv/bin/python test/bench/run_bench.py $(if $(SAVE),--save) $(if $(MOST),--most $(MOST)) \
	  $(if $(SMALL),--small --most 1e4 --rounds 1)
	@.venv/bin/python test/bench/run_tamaas.py $(if $(SAVE),--save) $(if $(SMALL),--small)
endif

figures: ## draw the pictures in docs/figures anew
	@bash .ci/setup build test
	@PATH="$(CURDIR)/.venv/bin:$$PATH" pip install -q --no-index --no-deps --no-build-isolation \
	  --upgrade --disable-pip-version-check --target build/package ./python
	@exe=$$(bash .ci/build release) && \
	  PYTHONPATH=build/package .venv/bin/python docs/figures/draw.py "$$exe"

fuzz: ## random decks, scenes and command lines (MINUTES=10); faults are kept in build/fuzz
	@bash .ci/setup build test
	@exe=$$(bash .ci/build release) && .venv/bin/python tools/fuzz.py --exe "$$exe" \
	  --minutes $(or $(MINUTES),10) --keep build/fuzz

mutants: ## changed lines that no test notices (SEED=1 NUMBER=10)
	@bash .ci/setup build test
	@bash .ci/setup mutants
	@.venv/bin/python tools/mutate.py --seed $(or $(SEED),1) --number $(or $(NUMBER),10)

maps: ## how good summits are, on maps pressed against their truth
	@bash .ci/setup build test
	@.venv/bin/python test/bench/run_maps.py $(MAPS)
	@.venv/bin/python test/bench/map_beside_tamaas.py --pixels 1024

validation: ## numbers of other programs and suites; the table of docs/reference/validation.md
	@bash .ci/setup build test
	@.venv/bin/python test/validation/make_page.py

setup: ## set up everything for building and testing
	@bash .ci/setup build test lint

clean: ## remove what was built (.venv stays)
	rm -rf build dist .pytest_cache .hypothesis
	find test -name __pycache__ -type d -prune -exec rm -rf {} +

tables: ## make the tables of docs/reference from the tables of the source
	@bash .ci/setup build test
	@exe=$$(bash .ci/build release) && .venv/bin/python test/support/reference_tables.py "$$exe"

machine: ## the historic arithmetic against a System/370 (needs hercules), kept in reference_output
	@bash .ci/setup build test
	@exe=$$(bash .ci/build release) && .venv/bin/python test/support/hex32_against_machine.py "$$exe"
