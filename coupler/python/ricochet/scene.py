"""Scenes as dicts: their TOML, and keys that a call changes."""
import json, math, os, pathlib

marker = "# Written by ricochet's Python package, which replaces it.\n"


def value_text(value):
    """A value as TOML."""
    if hasattr(value, "tolist"):  # of numpy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"found the number {value}, allowed: a finite number")
        return repr(value)
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(value_text, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key_text(key)} = {value_text(entry)}" for key, entry in value.items()) + " }"
    raise TypeError(f"found {value!r} ({type(value).__name__}), allowed: a number, a text, true, false, a list or a dict")


def key_text(key):
    if not isinstance(key, str):
        raise TypeError(f"found the key {key!r}, allowed: a text")
    bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if bare else json.dumps(key, ensure_ascii=False)


def is_tables(value):
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(entry, dict) for entry in value)


def to_toml(scene):
    """A dict as a TOML file: [tables] and [[lists of tables]] at the top, what is below them in one line each."""
    top, tables = "", ""
    for key, value in scene.items():
        if isinstance(value, dict) or is_tables(value):
            title = f"[{key_text(key)}]" if isinstance(value, dict) else f"[[{key_text(key)}]]"
            for table in [value] if isinstance(value, dict) else value:
                lines = [f"{key_text(name)} = {value_text(entry)}\n" for name, entry in table.items()]
                tables += f"\n{title}\n{''.join(lines)}"
        else:
            top += f"{key_text(key)} = {value_text(value)}\n"
    return top + tables


def with_absolute_paths(scene):
    """Paths of a dict count from the working folder, those of a scene file from its own."""
    scene = dict(scene)

    def absolute(table, key, program=False):
        path = table.get(key)
        if not isinstance(path, (str, os.PathLike)) or (program and "/" not in os.fspath(path)):
            return table
        return {**table, key: os.path.abspath(path)}

    if "scene" in scene:
        scene = absolute(scene, "scene")
    if is_tables(scene.get("body")):
        scene["body"] = [absolute(body, "interface_nodes") for body in scene["body"]]
        scene["body"] = [{**body, "mesh": absolute(body["mesh"], "gmsh")} if isinstance(body.get("mesh"), dict) else body
                         for body in scene["body"]]
    if is_tables(scene.get("participant")):
        scene["participant"] = [absolute(entry, "executable", program=True) for entry in scene["participant"]]
    return scene


def write(scene, folder):
    """Writes the dict into the folder as <name of the folder>.toml, where results keep it; returns its path."""
    folder = pathlib.Path(os.path.abspath(folder))
    name = folder.name or "given_scene"
    path, text = folder / f"{name}.toml", marker + to_toml(with_absolute_paths(scene))
    if path.exists() and not path.read_text(errors="replace").startswith(marker):
        raise FileExistsError(f"{path} is not of this package; give the results another folder: out=...")
    folder.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def set_arguments(changes):
    """--set KEY=VALUE of each change. In names of arguments two underscores stand for a dot: time__step_s; a dict holds
    keys below."""
    words = []
    for key, value in changes.items():
        key = key.replace("__", ".")
        if isinstance(value, dict):
            words += set_arguments({f"{key}.{name}": entry for name, entry in value.items()})
        else:
            words += ["--set", f"{key}={value_text(value)}"]
    return words
