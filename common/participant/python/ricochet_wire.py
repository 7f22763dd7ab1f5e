"""The wire of ricochet in Python: schema, strict codec and channel of docs/wire.md.

Needs Debian's python3-zmq, python3-msgpack, python3-numpy. A participant needs ricochet_participant.py only.
"""
import math, os, sys, time

import msgpack, numpy as np, zmq

import ricochet_memory

VERSION = 7
MAX_MESSAGE_BYTES = 1 << 30  # as codec.hpp
LOOK_EVERY_S = 0.05  # how often a wait in shared memory looks at the connection
HEADER = "kind:text version:integer run_id:text sequence:integer window:integer substep:integer"
ANSWER = ("records:array axial_stress:array probes:array departures:array contact_forces:array outline:array pairs_closed:integer gap_min_m:float "
          "gap_rate_min_m_s:float separated:boolean separation_time_s:float finished_early:boolean")
FIELDS = {  # every message of docs/wire.md
    "hello": "participant:text role:text solver:text solver_version:text scene_sha256:text process_id:integer "
             "machine:text shared_memory_path:text shared_memory_key:integer",
    "welcome": "participant:text timeout_s:float shared_memory:boolean",
    "describe": "",
    "description": "components:integer bodies:texts interface_body:array interface_position_m:array "
                   "interface_mass_kg:array critical_time_step_s:float capabilities:texts record_columns:texts axial_stress_columns:texts "
                   "probe_columns:texts contact_owner:boolean",
    "initialize": "protocol:text output_directory:text window_size_s:float substeps:integer driven_by:text "
                  "interface_mass_kg:array interface_stiffness:array directions:array scene_position_m:array "
                  "history_every:integer fields_every:integer axial_stress_every:integer probes_every:integer until_separated_plus_s:float "
                  "separation_windows:integer last_window:integer",
    "progress": "doing:text share_done:float",
    "initialized": "setup_s:float absolute:array",
    "synchronise": "integration:text link_absolute:array",
    "synchronised": "absolute:array velocity_m_s:array acceleration_m_s2:array",
    "reconfigure": "window_size_s:float interface_stiffness:array",
    "reconfigured": "",
    "advance": "windows:integer link_increment:array link_absolute:array accept_at_once:boolean "
               "absolute_requested:boolean records_requested:boolean touching:boolean",
    "advanced": "increment:array absolute:array velocity_m_s:array acceleration_m_s2:array " + ANSWER,
    "accept": "records_requested:boolean",
    "accepted": ANSWER,
    "load_state": "state:array frozen_contact:text",
    "state_loaded": "",
    "read_state": "",
    "state": "state:array state_scale:array",
    "save_state": "",
    "saved_state": "saved:bytes",
    "restore_state": "saved:bytes",
    "state_restored": "",
    "finish": "",
    "finished": "compute_s:float wait_s:float largest_drift:float spans_s:array records:array "
                "axial_stress:array probes:array departures:array contact_forces:array",
    "failure": "error_code:integer error_culprit:text error_text:text",
}
FIELDS = {kind: dict(field.split(":") for field in f"{HEADER} {own}".split()) for kind, own in FIELDS.items()}


class RunError(Exception):
    """Ends the run. `code` is the exit code: 2 input, 3 unstable, 4 participant, 5 protocol, 7 machine."""
    code = 4

    def __init__(self, text, code=None):
        super().__init__(text)
        self.code = code if code in (2, 3, 5, 7) else type(self).code


class ConfigError(RunError):
    code = 2


class SolverError(RunError):
    code = 3


class ProtocolError(RunError):
    code = 5


def array(values, columns):
    values = np.ascontiguousarray(np.asarray(values, dtype="<f8").reshape(-1, columns))
    return {"shape": list(values.shape), "data": values.tobytes()}


def read_array(value):
    if not isinstance(value, dict) or set(value) != {"shape", "data"}:
        raise ValueError("is not a map of 'shape' and 'data'")
    shape, data = value["shape"], value["data"]
    if not (isinstance(shape, list) and len(shape) == 2 and all(type(n) is int and n >= 0 for n in shape)):
        raise ValueError("has a shape that is not [rows, columns]")
    if not isinstance(data, bytes) or len(data) != 8 * shape[0] * shape[1]:
        raise ValueError(f"has the shape {shape[0]} x {shape[1]} but other data")
    return require_finite(np.frombuffer(data, dtype="<f8").reshape(shape))


def pack_state(**values):
    """Numbers and arrays of numbers as bytes, bit for bit, for `save_state`; `unpack_state` gives a dict of them."""
    arrays = {name: np.asarray(value, dtype="<f8") for name, value in values.items()}
    return msgpack.packb({name: [list(value.shape), value.tobytes()] for name, value in arrays.items()})


def unpack_state(saved):
    values = {name: np.frombuffer(data, dtype="<f8").reshape(shape).copy()
              for name, (shape, data) in msgpack.unpackb(saved).items()}
    return {name: value if value.shape else value.item() for name, value in values.items()}


def require_finite(values):
    if not np.all(np.isfinite(values)):
        raise ValueError("is not finite")
    return values


def read_number(value):
    if type(value) not in (int, float):
        raise ValueError("is not a number")
    return float(require_finite(value))


def of_type(kind):
    def read(value):
        if type(value) is kind:
            return value
        raise ValueError(f"is not of type {kind.__name__}")
    return read


def read_texts(value):
    return [of_type(str)(text) for text in of_type(list)(value)]


READ = {"text": of_type(str), "texts": read_texts, "boolean": of_type(bool), "integer": of_type(int),
        "float": read_number, "array": read_array, "bytes": of_type(bytes)}


def no_duplicates(pairs):
    if len(dict(pairs)) == len(pairs):
        return dict(pairs)
    raise ValueError("a field there twice")


def decode(data):
    """Strict: unknown, missing, duplicate, wrong-typed and non-finite fields are refused by name."""
    try:
        message = msgpack.unpackb(data, raw=False, object_pairs_hook=no_duplicates)
    except Exception as error:
        raise ProtocolError(f"the coupler sent {len(data)} bytes that are no message: {error}") from None
    if not isinstance(message, dict) or type(message.get("version")) is not int:
        raise ProtocolError("the coupler sent a message without the field 'version'")
    if message["version"] != VERSION:
        raise ProtocolError(f"the coupler speaks version {message['version']} of the wire protocol, this program "
                            f"speaks version {VERSION}: use the same release of ricochet on both ends")
    fields = FIELDS.get(message.get("kind") if isinstance(message.get("kind"), str) else None)
    if fields is None:
        raise ProtocolError(f"the coupler sent a message of the unknown kind {message.get('kind')!r}")
    for name in sorted(map(str, set(message) ^ set(fields))):
        fault = "without the field" if name in fields else "with the unknown field"
        raise ProtocolError(f"the coupler sent '{message['kind']}' {fault} '{name}'")
    for name, kind in fields.items():
        try:
            message[name] = READ[kind](message[name])
        except ValueError as error:
            raise ProtocolError(f"the coupler sent '{message['kind']}' whose field '{name}' {error}") from None
    return message


def encode(message):
    """Refuses at home what the coupler would refuse: NaN and infinity are the solver's fault, not the protocol's."""
    for name, kind in FIELDS[message["kind"]].items():
        try:
            READ[kind](message[name])
        except ValueError as error:
            raise (SolverError if "finite" in str(error) else RunError)(f"its '{name}' {error}") from None
    return msgpack.packb(message, use_bin_type=True)


def read_key(path, end):
    """The three lines by which the coupler and this participant know each other. The file may come until `end`."""
    while not os.path.exists(path) and time.monotonic() < end:
        time.sleep(0.02)
    try:
        with open(path, "rb") as file:
            keys = dict(map(bytes.split, file))
        return [keys[word] for word in (b"coupler", b"public", b"secret")]
    except (OSError, ValueError, KeyError) as error:
        raise ConfigError(f"--key: {path} is no key of a run: {error}") from None


class Channel:
    """One DEALER socket, and shared memory from `welcome` on if the coupler takes it. Every wait has a deadline; a
    connection that breaks ends the run."""

    def __init__(self, endpoint, watch_stdin, key=None):
        self.offered = self.shared = None
        self.socket = s = zmq.Context.instance().socket(zmq.DEALER)
        if key:
            s.curve_serverkey, s.curve_publickey, s.curve_secretkey = read_key(key, time.monotonic() + 60)
        s.setsockopt(zmq.LINGER, 500)  # for the last words
        self.monitor = s.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        self.poller = zmq.Poller()
        for source in [self.socket, self.monitor] + ([sys.stdin.fileno()] if watch_stdin else []):
            self.poller.register(source, zmq.POLLERR if isinstance(source, int) else zmq.POLLIN)
        try:
            s.connect(endpoint)
        except zmq.ZMQError as error:
            raise ConfigError(f"cannot connect to '{endpoint}': {error}") from None

    def offer_shared_memory(self, hello):
        self.offered = ricochet_memory.offered()
        if self.offered:
            hello |= {"shared_memory_path": self.offered.path, "shared_memory_key": self.offered.key}
        return hello

    def receive(self, timeout_s):
        end = time.monotonic() + timeout_s
        if self.shared:
            return decode(self.receive_shared(timeout_s, end))
        message = decode(self.receive_frame(timeout_s, end))
        if message["kind"] == "welcome":
            if message["shared_memory"] and not self.offered:
                raise ProtocolError("the coupler sent 'welcome' with shared memory, which 'hello' has not offered")
            self.shared = self.offered if message["shared_memory"] else None
        return message

    def receive_frame(self, timeout_s, end):
        while not self.socket.poll(0):
            ready = dict(self.poller.poll(max(0, math.ceil(1000 * (end - time.monotonic())))))
            if self.socket in ready or self.socket.poll(0):
                break
            if ready:
                raise RunError("the coupler is gone")
            if time.monotonic() >= end:
                raise RunError(f"the coupler has not answered within {timeout_s:.3g} s")
        return self.socket.recv()

    def receive_shared(self, timeout_s, end):
        next_look = time.monotonic() + LOOK_EVERY_S
        try:
            while (message := self.shared.receiver.receive(MAX_MESSAGE_BYTES)) is None:
                now = time.monotonic()
                if now >= end:
                    raise RunError(f"the coupler has not answered within {timeout_s:.3g} s")
                if now >= next_look:
                    next_look = now + LOOK_EVERY_S
                    ready = dict(self.poller.poll(0))
                    ready.pop(self.socket, None)
                    if ready and (message := self.shared.receiver.receive(MAX_MESSAGE_BYTES)) is None:
                        raise RunError("the coupler is gone")
                    if message is not None:
                        break  # its last words
                self.shared.wait(min(end, next_look))
            return message
        except ricochet_memory.Corrupted as error:
            raise ProtocolError(f"the coupler corrupted the shared memory: {error}") from None

    def send(self, message):
        data = encode(message)
        if not self.shared:
            self.socket.send(data, zmq.DONTWAIT)
            return
        try:
            self.shared.sender.send(data)
        except ricochet_memory.Corrupted as error:
            raise ProtocolError(f"the coupler corrupted the shared memory: {error}") from None

    def close(self):
        if self.shared:
            self.shared.flush_all()
        self.socket.disable_monitor()
        self.monitor.close()
        self.socket.close()
        zmq.Context.instance().term()
