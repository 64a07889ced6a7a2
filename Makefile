# make demo   bakes the built-in scene, writes a comparison figure and a page into out/
# make test   lints, type-checks, builds the web part and runs all tests but the slow ones
# make slow   runs those: what they find quick ones find too, or it rarely breaks
# All set up everything they need first.

PY := .venv/bin/python
WEB_SOURCES := $(shell find web -path web/node_modules -prune -o -type f -print) $(wildcard src/reflet/shaders/*.wgsl)
VIEWER := src/reflet/view/static/index.html

.PHONY: demo test slow lint figures web lock clean
.DELETE_ON_ERROR:

demo: .venv/.ready $(VIEWER)
	$(PY) examples/demo.py out

test: lint .venv/.browser $(VIEWER)
	$(PY) -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m "not slow"

slow: .venv/.browser $(VIEWER)
	$(PY) -m pytest -n 2 --dist load -m slow

lint: .venv/.ready web/node_modules/.ready
	.venv/bin/ruff check src tests examples benchmarks
	.venv/bin/ruff format --check src tests examples benchmarks
	.venv/bin/mypy
	cd web && npm run --silent check

# The pictures that the documentation shows.
figures: .venv/.ready .venv/.browser $(VIEWER)
	rm -rf out/figures
	.venv/bin/reflet bake teapot-room --out out/figures/teapot
	.venv/bin/reflet bake teapot-room --image-size 256 --em-size 128 --out out/figures/small
	.venv/bin/reflet compare out/figures/small --samples 16 --figure docs/comparison.png
	.venv/bin/reflet render out/figures/teapot --by-origin --elevation 42 -o docs/origins.png
	$(PY) tools/viewer_picture.py out/figures/teapot docs/viewer.png
	$(PY) examples/parameterizations.py out/figures/parameterizations
	$(PY) tools/parameterizations_picture.py out/figures/parameterizations docs/parameterizations.png
	.venv/bin/reflet sampling --figure docs/sampling.png
	$(PY) examples/mip_levels.py docs/mip_levels.png
	$(PY) examples/live_materials.py out/figures/live
	cp out/figures/live/strip.png docs/live_materials.png
	$(PY) examples/filtering_methods.py out/figures/methods
	cp out/figures/methods/methods.png docs/filtering_methods.png
	$(PY) examples/nonphotorealistic.py out/figures/drawings
	cp out/figures/drawings/drawings.png docs/nonphotorealistic.png
	cp out/figures/drawings/levels.png docs/drawn_levels.png
	$(PY) examples/any_brdf.py out/figures/any_brdf
	cp out/figures/any_brdf/any_brdf.png docs/any_brdf.png
	$(PY) examples/prefilter_levels.py docs/prefilter.png
	$(PY) examples/fresnel.py out/figures/fresnel
	cp out/figures/fresnel/fresnel.png out/figures/fresnel/schlick.png docs/
	$(PY) examples/prefiltered_maps.py out/figures/prefiltered
	cp out/figures/prefiltered/diffuse.png docs/diffuse_map.png
	cp out/figures/prefiltered/glossy.png docs/glossy_map.png
	$(PY) examples/glossy_every_frame.py out/figures/glossy
	cp out/figures/glossy/glossy.png docs/glossy_every_frame.png
	$(PY) benchmarks/glossy_sphere.py --out out/figures/sphere
	cp out/figures/sphere/glossy_sphere.png docs/glossy_sphere.png

web: $(VIEWER)

$(VIEWER): web/node_modules/.ready $(WEB_SOURCES)
	cd web && npm run --silent build
	@touch $@

.venv/.ready: requirements.lock pyproject.toml tools/setup.sh
	tools/setup.sh python
	@touch $@

web/node_modules/.ready: web/package.json web/package-lock.json tools/setup.sh
	tools/setup.sh web
	@touch $@

.venv/.browser: .venv/.ready
	tools/setup.sh browser
	@touch $@

# The lock names no index: hashes alone decide what is installed, wherever it comes from.
lock:
	uv pip compile --universal --python-version 3.11 --generate-hashes --no-header --no-annotate --no-emit-index-url \
	    --extra dev pyproject.toml -o requirements.lock

clean:
	rm -rf .venv out web/node_modules src/reflet/view/static
