"""YAML documents as the simulation reads them, and values at dotted paths in them."""
import copy
import json
import math
import re

import yaml

from .errors import SweepError


class Loader(yaml.SafeLoader):
    """Numbers as in YAML 1.2 and `simulate`: 1e5 is a number, "yes" is text, and a key occurs once."""

    yaml_implicit_resolvers = {}

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            name = self.construct_object(key, deep=True)
            if not isinstance(name, (str, int, float, bool)):
                raise SweepError("line %d: found a key that is no text; accepted: names" % (key.start_mark.line + 1))
            if name in seen:
                raise SweepError("line %d: found the key '%s' twice; accepted: once" % (key.start_mark.line + 1, name))
            seen.add(name)
        return super().construct_mapping(node, deep)


for tag, pattern, first in (
        ("null", r"~|null|Null|NULL|", "~nN\0"), ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
        ("int", r"[-+]?[0-9]+", "-+0123456789"),
        ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.nan|\.NaN|\.NAN", "-+0123456789.")):
    Loader.add_implicit_resolver("tag:yaml.org,2002:" + tag, re.compile("^(?:%s)$" % pattern), [c if c != "\0" else "" for c in first])
Loader.add_constructor("tag:yaml.org,2002:int", lambda loader, node: int(loader.construct_scalar(node)))
Loader.add_constructor("tag:yaml.org,2002:float", lambda loader, node: float(re.sub(r"\.(inf|nan)", r"\1", node.value.lower())))


def read_yaml(path):
    """The map in a YAML file."""
    try:
        with open(path, encoding="utf-8") as stream:
            document = yaml.load(stream, Loader)
    except OSError as error:
        raise SweepError("%s: cannot be read (%s); accepted: a readable YAML file" % (path, error.strerror))
    except UnicodeDecodeError:
        raise SweepError("%s: found bytes that are no UTF-8; accepted: a YAML file" % path)
    except SweepError as error:
        raise SweepError("%s: %s" % (path, error))
    except yaml.YAMLError as error:
        raise SweepError("%s: no YAML: %s" % (path, " ".join(str(error).split())))
    if not isinstance(document, dict):
        raise SweepError("%s: found no map of keys; accepted: a map" % path)
    return document


def set_by_path(document, path, value):
    """Sets one value as `simulate --set` does: missing maps are created, a number is an index into a list."""
    *parents, last = path.split(".")
    place = document
    for depth, key in enumerate(parents):
        if isinstance(place, list):
            place = place[find_item(place, key, path)]
            continue
        if not isinstance(place, dict):
            raise SweepError("%s: found '%s' below a value; accepted: keys of a map or list" % (path, key))
        if place.get(key) is None:
            place[key] = {}
        place = place[key]
    if isinstance(place, list):
        place[find_item(place, last, path)] = value
    elif isinstance(place, dict):
        place[last] = value
    else:
        raise SweepError("%s: found '%s' below a value; accepted: keys of a map or list" % (path, last))


def find_item(items, key, path):
    if not key.isdigit() or int(key) >= len(items):
        raise SweepError("%s: found '%s' as the place in a list of %d; accepted: the number of an item, from 0" % (path, key, len(items)))
    return int(key)


def merge(scene, overrides):
    """The scene with the values of the overrides, {dotted path: value}."""
    document = copy.deepcopy(scene)
    for path, value in overrides.items():
        set_by_path(document, path, copy.deepcopy(value))
    return document


def find_files(document, path=""):
    """(dotted path, name) of every file in a scene: keys called `file`."""
    pairs = document.items() if isinstance(document, dict) else enumerate(document) if isinstance(document, list) else ()
    for key, value in pairs:
        inner = "%s.%s" % (path, key) if path else str(key)
        if key == "file" and isinstance(value, str) and value:
            yield inner, value
        else:
            yield from find_files(value, inner)


def to_text(value):
    """A value as text for `simulate --set` and cells of the table. JSON is YAML except for values that are not finite."""
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, list):
        return "[%s]" % ", ".join(map(to_item, value))
    if isinstance(value, dict):
        return "{%s}" % ", ".join("%s: %s" % (to_item(key), to_item(item)) for key, item in value.items())
    return value if isinstance(value, str) else json.dumps(value)


def to_item(value):
    return json.dumps(value) if isinstance(value, str) else to_text(value)
