"""The stubs name what there is: each function of the table, each attribute, each option, with its arguments."""

import ast
import inspect
from pathlib import Path

import pytest

import modyn
from modyn import _modyn

PACKAGE = Path(modyn.__file__).parent
STUB = ast.parse((PACKAGE / "_modyn.pyi").read_text())


def members(name):
    """Returns the definitions in a class of the stub."""
    [body] = [node.body for node in STUB.body if isinstance(node, ast.ClassDef) and node.name == name]
    return {node.name: node for node in body if isinstance(node, ast.FunctionDef)}


def arguments(node):
    own = node.args
    names = [one.arg for one in own.posonlyargs + own.args]
    return [*names, *(one.arg for one in own.kwonlyargs)]


def test_each_function_of_the_table_is_a_method_with_a_stub():
    stubs = members("Robot")
    functions = modyn.functions()
    assert len(functions) > 50
    for name in functions:
        method = getattr(modyn.Robot, name)
        assert method.__doc__.startswith("Returns "), name
        assert list(inspect.signature(method).parameters) == arguments(stubs[name]), name
        assert ast.get_docstring(stubs[name]).split() == inspect.getdoc(method).split(), name


# The classes of the feature `gpu`.
GPU = {"GpuArray", "GpuRobot", "GpuRollout"}


@pytest.mark.parametrize("name", ["Robot", "CodeHandle", "Factorization", *(GPU & set(vars(_modyn)))])
def test_each_attribute_has_a_stub(name):
    inherited = set(dir(object)) | {"__module__", "__dir__", "__weakref__"}
    one = getattr(_modyn, name)
    own = {attribute for attribute in vars(one) if attribute not in inherited}
    assert own - set(members(name)) == set()
    # `__getattr__` finds fused functions; Python shows it as `__getattribute__`.
    assert set(members(name)) - own <= {"__getattr__"}
    for attribute, node in members(name).items():
        if attribute == "__getattr__":
            continue
        is_property = any(getattr(mark, "id", "") == "property" for mark in node.decorator_list)
        assert is_property == inspect.isgetsetdescriptor(getattr(one, attribute)), attribute


def test_each_option_has_a_stub():
    [options] = [node for node in STUB.body if isinstance(node, ast.ClassDef) and node.name == "Options"]
    stubs = [node.target.id for node in options.body if isinstance(node, ast.AnnAssign)]
    assert stubs == [name for name, *_ in _modyn.options_table()] + ["machine_code"]
    assert all(f"`{name}" in modyn.load.__doc__ for name in stubs)


def test_the_module_has_a_stub_and_a_name_for_everything():
    stubs = {node.name for node in STUB.body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    own = {name for name in vars(_modyn) if not name.startswith("__")}
    assert own & GPU in (set(), GPU)
    assert own | GPU == stubs - {"Options"}
    for name in modyn.__all__:
        assert getattr(modyn, name).__doc__, name


def test_the_package_is_typed():
    assert (PACKAGE / "py.typed").exists()
