"""Take part in a coupled run of ricochet from Python: derive from `Participant` and call `main`, or keep your own time
loop and call an `OwnLoop`.

The Python twin of common/participant (participant.hpp, own_loop.hpp, session.cpp). Link values are numpy arrays of shape
(n, components), absolute and in SI units; increments, resynchronisation, legal order, deadlines and failure messages
are done here.
"""
import argparse, dataclasses, hashlib, os, sys, threading, time, tomllib, traceback

import numpy as np

from ricochet_session import Session
from ricochet_wire import Channel, ConfigError, ProtocolError, RunError, SolverError, pack_state, unpack_state


@dataclasses.dataclass
class Description:
    """As in participant.hpp: one row per interface node, in the order of all link arrays."""
    name: str
    role: str                         # "explicit" | "implicit"
    solver: str
    solver_version: str = "1"
    scene_sha256: str = ""            # empty if it reads no scene
    bodies: list = dataclasses.field(default_factory=list)
    interface_body: object = ()       # n indices into `bodies`
    interface_position_m: object = ()  # n x components, reference configuration
    interface_mass_kg: object = ()    # n, own lumped mass
    components: int = 1
    critical_time_step_s: float = 0.0  # of its own explicit integration; 0: none needed
    capabilities: tuple = ("repeat_window",)
    record_columns: tuple = ()        # names of what `record` returns
    axial_stress_columns: tuple = ()  # "BODY/LOW/HIGH/SHARE" of what `axial_stress` returns; may stay empty
    probe_columns: tuple = ()         # "COLUMN/SHARE" of what `probes` returns, a column of probes.csv each
    contact_owner: bool = False


@dataclasses.dataclass
class ContactStatus:
    pairs_closed: int = 0
    gap_min_m: float = 0.0
    gap_rate_min_m_s: float = 0.0
    separated: bool = False
    separation_time_s: float = -1.0
    finished_early: bool = False


class Participant:
    """The contract of a solver. Explicit: link input is the displacement [m], output P = K u [N] of its own elements.
    Implicit: link input is the summed P of the explicit ones [N], output the tuple (u, v, a) of its interface nodes.
    Explicit with the capability "driven_by_force", where setup["driven_by"] is "force": it integrates its interface
    nodes itself with its own mass, M a = f - K u + lambda; link input is lambda at the end of the window [N], linear over
    its setup["substeps"] central difference steps, output the tuple (u, v, a).

    To be written:
      describe()                      a Description
      initialize(setup)               link output at t = 0; `setup`: the fields of the message `initialize`, a dict
      synchronise(integration, link)  at the present time: new accelerations from these link values; link output
      advance(window, link)           trial of the window that ends at window * window_size_s, from the last accepted
                                      state; link output
      accept()                        makes the last trial final
    """

    def advance_substep(self, window, substep, link):
        """With the capability "single_substep", driven by force: trial of the one substep 1 .. setup["substeps"] of that
        window, each accepted before the next; `link`: lambda at its end, linear from the end of the one before."""
        raise RunError("it announces the capability 'single_substep' but cannot compute a single substep")

    def reconfigure(self, setup):
        """With the capability "reconfigure", between windows: `setup` is that of `initialize` but for `window_size_s`, the
        size of the windows to come, and `interface_stiffness`. Nothing moves."""
        raise RunError("it announces the capability 'reconfigure' but does not implement it")

    def contact_status(self):
        return ContactStatus()

    def record(self):
        """One history row after the last accepted window, in the order of `record_columns`."""
        return []

    def progress(self, doing, share_done=-1.0):
        """To be called by an `initialize` that takes long: what it does, for the user, and the share of it that is done
        (< 0: unknown). One that says nothing for longer than the scene's timeout is taken for dead."""

    def axial_stress(self):
        """Its share of the mean axial stress of each layer [Pa], in the order of `axial_stress_columns`."""
        return []

    def probes(self):
        """Its share of each of `probe_columns`: of motion the sum over the nodes that it integrates, of which each counts
        by its shape function, of strain and stress the mean over its elements."""
        return []

    def write_fields(self, window):
        pass

    def load_state(self, state, frozen_contact):
        """With the capability "load_state": see participant.hpp. `frozen_contact`: "open" | "sticking"."""
        raise RunError("it announces the capability 'load_state' but cannot load a state")

    def read_state(self):
        """The tuple (state, scale), each a vector: as `load_state` takes it."""
        raise RunError("it announces the capability 'load_state' but cannot tell its state")

    def save_state(self):
        """With the capability "save_state": bytes from which `restore_state` makes, in another process, all that the
        windows to come are computed from and what was booked so far, bit for bit. `pack_state` makes them of numbers."""
        raise RunError("it announces the capability 'save_state' but cannot save its state")

    def restore_state(self, saved):
        raise RunError("it announces the capability 'save_state' but cannot restore a state")

    def finish(self):
        pass


def arguments():
    """The command line every participant is started with."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", help="scene file (TOML)")
    parser.add_argument("--name", required=True, help="name of the participant in the scene")
    parser.add_argument("--connect", required=True, help="endpoint of the coupler, ipc://... or tcp://address:port")
    parser.add_argument("--key", help="file with the key by which the coupler knows this participant")
    parser.add_argument("--watch-stdin", action="store_true", help="end at once when standard input closes")
    return parser.parse_args()


def read_scene(path, name):
    """A scene file as a dict, its entry of the participant, and the SHA-256 of it, of its mesh files and of its files of
    interface nodes, whose paths are absolute in the dict. The coupler has checked the values already."""
    with open(path, "rb") as file:
        data = file.read()
    scene = tomllib.loads(data.decode())
    entries = [entry for entry in scene.get("participant", []) if entry["name"] == name]
    if not entries:
        raise ConfigError(f"{path}: found no [[participant]] with name = \"{name}\"")
    for body in scene["body"]:
        if isinstance(body.get("material"), str):
            own = scene.get("material", {})
            if body["material"] not in own:
                raise ConfigError(f"{path}: found material \"{body['material']}\" of ricochet's library, whose numbers this "
                                  f"program has not; allowed: the same numbers in a table [material.{body['material']}]")
            body["material"] = own[body["material"]]
    files = [(body["mesh"], key) for body in scene["body"] for key in ("gmsh", "inp") if key in body.get("mesh", {})]
    files += [(body, "interface_nodes") for body in scene["body"] if "interface_nodes" in body]
    for table, key in files:
        table[key] = os.path.join(os.path.dirname(os.path.abspath(path)), table[key])
        with open(table[key], "rb") as file:
            data += file.read()
    return scene, entries[0], hashlib.sha256(data).hexdigest()


def reason(error):
    """Exit code and text: numbers that went wrong are 3, what the machine lacks 7, what is no fault
    of the run's input or peers 4."""
    if isinstance(error, RunError):
        return error.code, str(error)
    if isinstance(error, (MemoryError, OSError)):
        return 7, f"{type(error).__name__}: {error}"
    unstable = isinstance(error, (ArithmeticError, np.linalg.LinAlgError))
    last = traceback.extract_tb(error.__traceback__)[-1]
    place = f"{os.path.basename(last.filename)}, line {last.lineno}, in {last.name}"
    words = f": {error}" if str(error) else ""
    return 3 if unstable else 4, f"{type(error).__name__}{words} ({place})"


def converse(session, channel):
    session.send = channel.send
    channel.send(channel.offer_shared_memory(session.hello()))
    while session.state != "finished":
        begin = time.monotonic()
        request = channel.receive(session.timeout_s)
        session.wait_s += time.monotonic() - begin
        reply = session.handle(request)
        if reply is not None:
            channel.send(reply)


def require_first_process(options):
    """mpirun or srun in front of a program (key `launch`) starts it several times: a participant is one of these."""
    for variable in ["OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID"] if options.watch_stdin else []:
        if int(os.environ.get(variable) or 0) > 0:
            raise ConfigError(f"found process {os.environ[variable]} ({variable}) of those that `launch` starts taking "
                              "part, allowed: process 0 alone; the others are to compute for it, without the SDK")


def serve(make, options):
    """Makes the participant, make(scene, name), and runs it until the coupler says finish; returns the exit code."""
    session = channel = None
    try:
        require_first_process(options)
        session = Session(make(options.scene, options.name))
        channel = Channel(options.connect, options.watch_stdin, options.key)
        converse(session, channel)
        return 0
    except Exception as error:
        code, text = reason(error)
        if not isinstance(error, RunError):
            traceback.print_exc()
        if channel:
            text = f"window {session.window}: {text}" if session.window > 0 and not text.startswith("window ") else text
            channel.send(session.message("failure", error_code=code, error_culprit=options.name, error_text=text))
        print(f"{options.name}: error: {text}", file=sys.stderr, flush=True)
        return code
    finally:
        if channel:
            channel.close()


def main(make):
    """The main program of a participant: serve with the options of the command line."""
    sys.exit(serve(make, arguments()))


class Relay(Participant):
    """The participant that `serve` runs in a thread: it passes each window to the loop of another thread and sleeps until
    that is done. Only one of the two threads is at work, so nothing else needs a lock."""

    def __init__(self, description):
        self.description, self.to_loop, self.to_coupler = description, threading.Semaphore(0), threading.Semaphore(0)
        self.setup, self.integration, self.link, self.left, self.over = {}, "", None, None, False
        self.time_step, self.save, self.restore, self.tried = 0.0, False, False, False
        self.setting_up = False

    def describe(self):
        return self.description

    def initialize(self, setup):
        self.setup = setup
        self.hand_over()
        return [self.written] * 3 if setup["driven_by"] == "force" else self.written  # the rates are asked for later

    def synchronise(self, integration, link):
        self.integration = integration
        return self.compute(0.0, False, link)

    def reconfigure(self, setup):
        self.setup = setup

    def advance(self, window, link):
        output = self.compute(self.setup["window_size_s"], "repeat_window" in self.description.capabilities, link)
        self.tried = True
        return output

    def compute(self, time_step, may_repeat, link):
        self.time_step, self.restore, self.save = time_step, self.tried, may_repeat and not self.tried
        self.tried, self.link = False, link
        self.hand_over()
        return self.written

    def hand_over(self):
        self.to_loop.release()
        self.to_coupler.acquire()
        if self.left:
            raise self.left

    def accept(self):
        self.tried = False

    def record(self):
        return self.recorded


class OwnLoop:
    """For codes that own their time loop; the twin of own_loop.hpp:

        with OwnLoop(description, arguments()) as loop:
            loop.initialize(force or displacement at t = 0, history row)
            while loop.ongoing():
                if loop.must_save(): saved = copy of the state
                state.step(loop.max_time_step(), loop.read())
                loop.write(link output, history row)
                loop.advance()
                if loop.must_restore(): state = copy of saved
        sys.exit(loop.finalize())

    Every turn computes one whole window, which ends when the time `max_time_step()` has passed. It may be 0: then the
    coupler synchronises, which is a window in which no time passes (new accelerations from the link values that are read,
    nothing else moves). A run that fails ends the program by SystemExit with its exit code. An exception that leaves the `with`
    is told the coupler as the reason; a ConfigError or SolverError ends the program with its code.
    """

    def __init__(self, description, options):
        self.relay = Relay(description)
        self.exit_code = 4
        self.thread = threading.Thread(target=self.converse, args=[options], daemon=True)

    def converse(self, options):
        self.exit_code = serve(lambda scene, name: self.relay, options)
        self.relay.over = True
        self.relay.to_loop.release()

    def __enter__(self):
        return self

    def __exit__(self, kind, error, traceback):
        self.leave(error)
        if isinstance(error, RunError):
            sys.exit(self.exit_code)

    def initialize(self, value, record=()):
        self.write(value, record)
        self.thread.start()
        self.wait()
        self.relay.setting_up = True

    @property
    def setup(self):
        """The coupler's settings, the fields of the message `initialize`; after `initialize`."""
        return self.relay.setup

    def progress(self, doing, share_done=-1.0):
        """Tells what a long set-up is doing, and the share that is done (< 0: unknown): between `initialize` and the first
        question about the time loop, while the coupler still waits for an answer to its `initialize`."""
        if not self.relay.setting_up:
            raise ConfigError("progress is told between initialize and the first turn of the time loop")
        self.relay.progress(doing, share_done)

    def ready(self):
        """The relay, with a window to compute."""
        if self.relay.setting_up:
            self.relay.setting_up = False
            self.resume()
        return self.relay

    def integration(self):
        """By which integration an implicit participant is to go on: "implicit_newmark" | "explicit_central"."""
        return self.ready().integration

    def ongoing(self):
        return not self.ready().over

    def max_time_step(self):
        return self.ready().time_step

    def must_save(self):
        """A new window begins, and the coupler may ask for it again."""
        return self.ready().save

    def must_restore(self):
        """The window is void: go back to where `must_save` was true."""
        return self.ready().restore and self.ongoing()

    def read(self):
        """Link input at the end of the window, shape (n, components)."""
        return self.ready().link

    def write(self, output, record=()):
        """Link output and history row at the end of the window."""
        self.relay.written, self.relay.recorded = output, list(record)

    def advance(self):
        self.ready()
        self.resume()

    def resume(self):
        self.relay.to_coupler.release()
        self.wait()

    def wait(self):
        self.relay.to_loop.acquire()
        if self.relay.over and self.exit_code:
            sys.exit(self.exit_code)

    def leave(self, error=None):
        if self.thread.is_alive():
            if not self.relay.over:
                early = RunError("the solver left its time loop before the run was over")
                self.relay.left = error if isinstance(error, Exception) else early
                self.relay.to_coupler.release()
            self.thread.join()

    def finalize(self):
        """Waits for the end of the conversation; the exit code for `sys.exit`."""
        self.leave()
        return self.exit_code
