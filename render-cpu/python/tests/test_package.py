"""The package itself: types, documentation."""

import ast
import inspect
import pathlib

import halflight
from halflight import _native, half_vector, regularize

FOLDER = pathlib.Path(halflight.__file__).parent


def test_the_stub_names_what_the_compiled_half_has():
    stub = ast.parse((FOLDER / "_native.pyi").read_text())

    def names(body):
        found = set()
        for node in body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                found.add(node.name)
            elif isinstance(node, ast.AnnAssign):
                found.add(node.target.id)
        return found

    hidden = {"__doc__", "__file__", "__loader__", "__name__", "__package__", "__spec__", "__all__"}
    assert names(stub.body) == set(dir(_native)) - hidden
    for node in stub.body:
        if isinstance(node, ast.ClassDef) and node.name != "SceneError":
            special = {"__getitem__", "__contains__", "__array__"}
            have = {n for n in vars(getattr(_native, node.name)) if not n.startswith("__") or n in special}
            assert names(node.body) == have, node.name


def test_the_package_says_that_it_is_typed():
    assert (FOLDER / "py.typed").exists()


def test_everything_public_is_documented():
    objects = [halflight, half_vector, regularize]
    objects += [getattr(halflight, name) for name in halflight.__all__ if name != "__version__"]
    for module in (half_vector, regularize):
        objects += [f for n, f in vars(module).items() if inspect.isfunction(f) and not n.startswith("_") and n != "flatten"]
    for kind in (halflight.Scene, halflight.Image, halflight.Comparison, halflight.Bsdf):
        objects += [v for n, v in vars(kind).items() if not n.startswith("_")]
    for item in objects:
        assert inspect.getdoc(item), item


def test_versions_agree():
    assert halflight.__version__ == _native.__version__
