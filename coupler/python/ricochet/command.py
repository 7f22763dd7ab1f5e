"""Calls of the `ricochet` command."""
import os, pathlib, shutil, signal, subprocess, sys, tempfile, threading

from . import scene as scenes
from .result import Page, Result, Study


class RicochetError(Exception):
    """The command failed: `exit_code` as in docs/commands.md, `text` what it said, `folder` of the results so far."""

    def __init__(self, exit_code, text, folder=None):
        super().__init__(f"{text} (exit code {exit_code})")
        self.exit_code, self.text, self.folder = exit_code, text, folder


class SceneError(RicochetError):
    """The scene, the study or a change is wrong."""


class UnstableError(RicochetError):
    """Its numbers no longer mean anything."""


class ParticipantError(RicochetError):
    """A participant is missing, died, hung or failed by itself."""


class ProtocolError(RicochetError):
    """A participant broke the coupling protocol."""


class ModelError(RicochetError):
    """The run left the model."""


class MachineError(RicochetError):
    """The machine lacks memory, disk or files."""


error_of_code = {2: SceneError, 3: UnstableError, 4: ParticipantError, 5: ProtocolError, 6: ModelError, 7: MachineError}


def program():
    """The command: the environment's RICOCHET, else the script of the checkout that this package lies in, else PATH."""
    if os.environ.get("RICOCHET"):
        return os.environ["RICOCHET"]
    checkout = pathlib.Path(__file__).resolve().parents[3]
    if (checkout / "ricochet").is_file() and (checkout / "coupler/python/ricochet").is_dir():
        return str(checkout / "ricochet")
    found = shutil.which("ricochet")
    if not found:
        raise FileNotFoundError("found no command ricochet; allowed: one on PATH, or the path of one in the environment's "
                                "variable RICOCHET (in a checkout that is its script ./ricochet)")
    return found


def show(line):
    print(line, file=sys.stderr, flush=True)


def call(words, progress, folder=None):
    """Runs the command to its end; `progress` hears each line of its standard error. Returns its standard output."""
    try:
        process = subprocess.Popen([program(), *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   stdin=subprocess.DEVNULL, errors="replace")
    except OSError as error:
        raise RicochetError(4, f"cannot start {program()}: {error}") from error
    printed, said = [], []
    reader = threading.Thread(target=lambda: printed.extend(process.stdout))
    reader.start()
    try:
        for line in process.stderr:
            said.append(line.rstrip("\n"))
            if progress and not said[-1].startswith("ricochet: "):
                progress(said[-1])
        process.wait()
    finally:  # an interrupt, or an error of `progress`: the run ends, and leaves what it has
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.stderr.read()
            process.wait()
        reader.join()
        process.stdout.close()
        process.stderr.close()
    if process.returncode != 0:
        code = process.returncode if process.returncode > 0 else 128 - process.returncode
        last = max((i for i, line in enumerate(said) if line.startswith("ricochet: ")), default=0)
        text = "\n".join(said[last:]).removeprefix("ricochet: ")
        raise error_of_code.get(code, RicochetError)(code, text, folder)
    return "".join(printed)


def folder_of(given, out):
    if out is not None:
        return pathlib.Path(out)
    return pathlib.Path("out") / ("python" if isinstance(given, dict) else pathlib.Path(given).stem)


def file_of(given, folder):
    return str(scenes.write(given, folder) if isinstance(given, dict) else pathlib.Path(given))


def run(scene, out=None, progress=show, **changes):
    """Computes a scene, a path or a dict, with keys changed, and returns its Result. `progress` hears each line that says
    how far it is; None: nobody."""
    arguments, folder = scenes.set_arguments(changes), folder_of(scene, out)
    text = call(["run", file_of(scene, folder), "--out", str(folder), *arguments], progress, folder)
    return Result(folder, text)


def check(scene, **changes):
    """What `ricochet check` says of a scene, a path or a dict, with keys changed."""
    arguments = scenes.set_arguments(changes)
    with tempfile.TemporaryDirectory() as scratch:
        return call(["check", file_of(scene, scratch), *arguments], None)


def draw(scene, out=None, height=800, **changes):
    """The scene, a path or a dict, with keys changed, drawn before it runs: for the last line of a cell of a notebook."""
    arguments, folder = scenes.set_arguments(changes), folder_of(scene, out)
    if out is None:
        folder = folder.with_name(folder.name + "_scene")
    call(["check", file_of(scene, folder), "--picture", "--out", str(folder), *arguments], None, folder)
    return Page(folder / "scene.html", height)


def study(study, out=None, progress=show, **changes):
    """Computes a study, a path or a dict, its scene with keys changed, and returns its Study."""
    arguments, folder = scenes.set_arguments(changes), folder_of(study, out)
    text = call(["study", file_of(study, folder), "--out", str(folder), *arguments], progress, folder)
    return Study(folder, text)
