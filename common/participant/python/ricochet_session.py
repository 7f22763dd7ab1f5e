"""The conversation of a participant without the bytes; the Python twin of common/participant/session.cpp."""
import dataclasses, os, time

import msgpack
import numpy as np

from ricochet_wire import VERSION, ProtocolError, RunError, array, pack_state, unpack_state

ORDER = {  # what the coupler may ask in each state of this end
    "greeting": ["welcome"], "welcomed": ["describe"], "described": ["initialize"], "initialized": ["synchronise"],
    "ready": ["advance", "synchronise", "reconfigure", "load_state", "read_state", "save_state", "restore_state",
              "finish"], "tried": ["advance", "accept", "synchronise"],
}
EMPTY = np.zeros((0, 0))
TOLD = {"axial_stress": "axial_stress_columns", "probes": "probe_columns"}  # rows beside the history, and their columns


class Session:
    """Requests of the coupler into calls of a participant, results into replies. Like session.cpp."""

    def __init__(self, participant):
        self.participant, self.description = participant, participant.describe()
        d = self.description
        self.shape = (len(d.interface_body), d.components)
        self.state, self.run_id, self.sequence, self.asked = "greeting", "", 0, 0
        self.window = self.accepted = 0
        self.substep = self.accepted_substep = 0  # of the trial, 0: whole window; of the window under way
        self.moves = False  # driven by force: answers displacement, velocity, acceleration
        self.input = self.accepted_input = self.output = self.accepted_output = np.zeros(self.shape)
        self.rates, self.rows, self.told, self.spans = (EMPTY, EMPTY), [], {what: [] for what in TOLD}, []
        self.drift = self.compute_s = self.wait_s = 0.0
        self.fields_window, self.timeout_s, self.setup = -1, 60.0, {}
        self.send, self.initializing = None, False  # where what is no answer goes, and when it may

    def message(self, kind, **fields):
        fields |= {"kind": kind, "version": VERSION, "run_id": self.run_id, "sequence": self.sequence,
                   "window": self.window, "substep": self.substep}
        self.sequence += 1
        return fields

    def hello(self):
        d = self.description
        return self.message("hello", participant=d.name, role=d.role, solver=d.solver, process_id=os.getpid(),
                            machine=os.environ.get("SLURMD_NODENAME") or os.uname().nodename,
                            solver_version=d.solver_version, scene_sha256=d.scene_sha256, shared_memory_path="",
                            shared_memory_key=0)  # the channel offers some

    def handle(self, request):
        """The reply, or None if there is none."""
        kind = request["kind"]
        if kind == "failure":
            raise RunError(f"the coupler ended the run: {request['error_text']}", request["error_code"])
        self.require(kind in ORDER[self.state], f"'{kind}' while {self.state}, expected one of {ORDER[self.state]}")
        self.require(request["sequence"] == self.asked, f"message number {request['sequence']}, expected {self.asked}")
        self.require(kind == "welcome" or request["run_id"] == self.run_id, f"a message of run '{request['run_id']}'")
        self.asked += 1
        begin = time.monotonic()
        reply = getattr(self, kind)(request)
        end = time.monotonic()
        self.compute_s += end - begin
        if len(self.spans) < 2000:
            self.spans.append((self.window, begin, end))
        return reply

    def can(self, capability):
        return capability in self.description.capabilities

    def require(self, holds, what):
        if not holds:
            raise ProtocolError(f"the coupler sent {what}")

    def welcome(self, request):
        self.require(request["participant"] == self.description.name, f"a welcome to '{request['participant']}'")
        self.require(request["timeout_s"] > 0, f"the timeout {request['timeout_s']} s")
        self.state, self.run_id, self.timeout_s = "welcomed", request["run_id"], request["timeout_s"]

    def describe(self, request):
        d, self.state = self.description, "described"
        return self.message(
            "description", components=d.components, bodies=list(d.bodies), interface_body=array(d.interface_body, 1),
            interface_position_m=array(d.interface_position_m, d.components), capabilities=list(d.capabilities),
            interface_mass_kg=array(d.interface_mass_kg, 1), critical_time_step_s=float(d.critical_time_step_s),
            record_columns=["window", *d.record_columns], contact_owner=d.contact_owner,
            **{columns: ["window", *getattr(d, columns)] if getattr(d, columns) else [] for columns in TOLD.values()})

    def initialize(self, request):
        self.require(request["window_size_s"] > 0 and request["history_every"] >= 1 and request["substeps"] >= 1,
                     "a wrong 'initialize'")
        drive, d = request["driven_by"], self.description
        able = ["force"] if d.role == "implicit" else ["displacement", "force"][:1 + self.can("driven_by_force")]
        self.require(drive in able, f"'initialize' that drives it by {drive}, which it is not made for")
        self.check_stiffness(request)
        self.require(request["interface_mass_kg"].shape == (self.shape[0], 1), "masses of another number of nodes")
        self.require(request["scene_position_m"].shape == self.shape, "places of another number of nodes")
        self.require(request["directions"].shape == (self.shape[1], self.shape[1]), "directions of another model")
        self.setup, self.state, self.moves, begin = request, "initialized", drive == "force", time.monotonic()
        self.participant.progress, self.initializing = self.progress, True
        self.take(self.participant.initialize(request))
        self.initializing = False
        return self.message("initialized", setup_s=time.monotonic() - begin, absolute=self.full(self.value))

    def check_stiffness(self, request):
        stiffness, size = request["interface_stiffness"].shape, self.shape[0] * self.shape[1]
        self.require(stiffness[0] == 0 or self.can("interface_stiffness") and stiffness == (size, size),
                     f"an interface stiffness of shape {stiffness}, which this participant cannot do")

    def reconfigure(self, request):
        self.require(self.can("reconfigure"), "'reconfigure', which this participant cannot do")
        self.require(request["window_size_s"] > 0 and self.accepted_substep == 0, "a wrong 'reconfigure'")
        self.check_stiffness(request)
        self.change(request["window_size_s"], request["interface_stiffness"])
        return self.message("reconfigured")

    def change(self, window_size_s, interface_stiffness):
        self.setup = self.setup | {"window_size_s": window_size_s, "interface_stiffness": interface_stiffness}
        self.participant.reconfigure(self.setup)

    def progress(self, doing, share_done=-1.0):
        if self.send and self.initializing:
            self.send(self.message("progress", doing=doing, share_done=float(share_done)))

    def synchronise(self, request):
        self.require(request["integration"] in ("implicit_newmark", "explicit_central"), "an unknown integration")
        self.input = self.accepted_input = self.rows_of(request, "link_absolute")
        self.take(self.participant.synchronise(request["integration"], self.input))
        self.output = self.accepted_output = self.value
        self.state = "ready"
        if self.accepted == 0:
            # The coupler may synchronise the start more than once.
            self.rows, self.told = [], {what: [] for what in TOLD}
            self.record(self.setup["fields_every"] > 0)
            self.record_told()
        return self.message("synchronised", absolute=self.full(self.value), **self.motion())

    def advance(self, request):
        at_once, last = request["accept_at_once"], self.setup["last_window"]
        self.require(request["window"] == self.accepted + 1 <= last, f"window {request['window']}")
        self.check_substep(request)
        self.require(request["windows"] == 1 or (self.shape[0] == 0 and at_once and request["windows"] > 0),
                     "several windows at once to a participant with interface nodes")
        self.require(self.state == "ready" or self.can("repeat_window"), "a repeated window")
        self.receive(request)
        self.substep = request["substep"]
        last = min(last, self.accepted + request["windows"])
        while True:
            self.window = self.accepted + 1
            if self.substep:
                self.take(self.participant.advance_substep(self.window, self.substep, self.input))
            else:
                self.take(self.participant.advance(self.window, self.input))
            increment = self.value - self.accepted_output
            self.output = self.value if request["absolute_requested"] else self.accepted_output + increment
            if at_once:
                self.accept_window()
            if not at_once or self.window == last or self.participant.contact_status().finished_early:
                break
        self.state = "ready" if at_once else "tried"
        absolute = self.full(self.value) if request["absolute_requested"] else self.none()
        return self.message("advanced", increment=self.full(increment), absolute=absolute, **self.motion(),
                            **self.answer(request["records_requested"]))

    def check_substep(self, request):
        step, last = request["substep"], self.setup["substeps"]
        whole = step == 0 and self.accepted_substep == 0
        self.require(whole or self.can("single_substep") and self.moves and step == self.accepted_substep + 1 <= last,
                     f"substep {step} of {last}, {self.accepted_substep} are accepted")

    def accept(self, request):
        self.require(request["window"] == self.window, f"'accept' of window {request['window']}")
        self.accept_window()
        self.state = "ready"
        return self.message("accepted", **self.answer(request["records_requested"]))

    def load_state(self, request):
        self.require(self.can("load_state"), "'load_state', which this participant cannot do")
        self.require(request["frozen_contact"] in ("open", "sticking"), "an unknown frozen contact")
        self.require(request["state"].shape == (len(self.participant.read_state()[0]), 1), "a state of another size")
        self.participant.load_state(request["state"][:, 0], request["frozen_contact"])
        self.state = "initialized"
        return self.message("state_loaded")

    def read_state(self, request):
        self.require(self.can("load_state"), "'read_state', which this participant cannot do")
        state, scale = self.participant.read_state()
        return self.message("state", state=array(state, 1), state_scale=array(scale, 1))

    def save_state(self, request):
        """All that this end and the participant go on from."""
        self.require(self.can("save_state"), "'save_state', which this participant cannot do")
        own = self.participant.save_state()
        if type(own) is not bytes:
            raise RunError(f"its save_state returned {type(own).__name__}, expected bytes")
        link = pack_state(window=self.accepted, fields_window=self.fields_window, input=self.accepted_input,
                          output=self.accepted_output, drift=self.drift, rows=self.rows, **self.told,
                          window_size_s=self.setup["window_size_s"], stiffness=self.setup["interface_stiffness"])
        return self.message("saved_state", saved=msgpack.packb([link, own]))

    def restore_state(self, request):
        self.require(self.can("save_state"), "'restore_state', which this participant cannot do")
        link, own = msgpack.unpackb(request["saved"])
        s = unpack_state(link)
        self.require(s["input"].shape == s["output"].shape == self.shape, "the state of another interface")
        self.accepted = self.window = int(s["window"])
        self.fields_window, self.drift = int(s["fields_window"]), float(s["drift"])
        self.input = self.accepted_input = s["input"]
        self.output = self.accepted_output = s["output"]
        self.rows, self.told = s["rows"].tolist(), {what: s[what].tolist() for what in TOLD}
        if float(s["window_size_s"]) != self.setup["window_size_s"]:
            self.change(float(s["window_size_s"]), s["stiffness"])
        self.participant.restore_state(own)
        return self.message("state_restored")

    def finish(self, request):
        if self.setup["fields_every"] > 0 and self.fields_window != self.accepted:
            self.participant.write_fields(self.accepted)
        self.participant.finish()
        self.state = "finished"
        return self.message("finished", compute_s=self.compute_s, wait_s=self.wait_s, largest_drift=self.drift,
                            spans_s=array(self.spans, 3), records=self.records(True),
                            **self.rows_told(True), departures=array([], 14), contact_forces=array([], 1))

    def receive(self, request):
        """x = X + d, or the absolute value that came with it."""
        self.input = self.accepted_input + self.rows_of(request, "link_increment")
        if len(request["link_absolute"]) == 0:
            return
        absolute = self.rows_of(request, "link_absolute")
        difference, scale = np.max(abs(self.input - absolute), initial=0), np.max(abs(absolute), initial=0)
        self.drift, self.input = max(self.drift, float(difference / (scale or 1.0))), absolute

    def accept_window(self):
        self.participant.accept()
        self.accepted_input, self.accepted_output = self.input, self.output
        self.accepted_substep = self.substep % self.setup["substeps"]
        if self.accepted_substep:
            return  # the window goes on
        self.accepted = self.window
        every = self.setup["fields_every"]
        fields = every > 0 and (self.window % every == 0 or self.window == self.setup["last_window"])
        if self.window % self.setup["history_every"] == 0:
            self.record(fields)
        elif fields:
            self.write_fields()
        self.record_told()

    def record(self, fields):
        row = list(self.participant.record())
        if len(row) != len(self.description.record_columns):
            raise RunError(f"recorded {len(row)} numbers, announced {len(self.description.record_columns)} columns")
        self.rows.append([self.accepted, *row])
        if fields:
            self.write_fields()

    def record_told(self):
        for what, rows in self.told.items():
            every, columns = self.setup[f"{what}_every"], getattr(self.description, TOLD[what])
            if every == 0 or not columns or self.accepted % every:
                continue
            row = list(getattr(self.participant, what)())
            if len(row) != len(columns):
                raise RunError(f"{what} told {len(row)} numbers, announced {len(columns)} {TOLD[what]}")
            rows.append([self.accepted, *row])

    def write_fields(self):
        self.participant.write_fields(self.accepted)
        self.fields_window = self.accepted

    def take(self, output):
        """Checks and copies what the solver returned: it may go on writing into its own arrays."""
        values = [np.array(x, dtype=float) for x in (output if self.moves and np.iterable(output) else [output])]
        if len(values) != (3 if self.moves else 1) or any(x.size != np.prod(self.shape) for x in values):
            raise RunError("the link output has not the shape of " + (
                f"3 x {self.shape}: displacement, velocity, acceleration" if self.moves else f"{self.shape}: force"))
        values = [x.reshape(self.shape) for x in values]
        self.value, self.rates = values[0], tuple(values[1:]) if self.moves else (EMPTY, EMPTY)

    def rows_of(self, request, field):
        self.require(request[field].shape == self.shape, f"'{field}' of shape {request[field].shape}")
        return request[field]

    def full(self, values):
        return array(values, self.shape[1])

    def none(self):
        return array([], self.shape[1])

    def records(self, requested):
        rows, self.rows = (self.rows, []) if requested else ([], self.rows)
        return array(rows, 1 + len(self.description.record_columns))

    def rows_told(self, requested):
        told, self.told = (self.told, {what: [] for what in TOLD}) if requested else ({}, self.told)
        return {what: array(told.get(what, []), 1 + len(getattr(self.description, columns)))
                for what, columns in TOLD.items()}

    def motion(self):
        velocity, acceleration = map(self.full, self.rates)
        return {"velocity_m_s": velocity, "acceleration_m_s2": acceleration}

    def answer(self, records_requested):  # it does not look for what leaves the model
        return {"records": self.records(records_requested), **self.rows_told(records_requested),
                "departures": array([], 14), "contact_forces": array([], 1),
                "outline": array([], 2 + self.shape[1]), **dataclasses.asdict(self.participant.contact_status())}
