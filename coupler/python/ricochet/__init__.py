"""Run scenes and studies of ricochet from Python, and read their results: docs/python.md.

    import ricochet
    result = ricochet.run("configs/kim_impact.toml", time__step_s=5e-8)
    result.history["contact_force_n"]
"""
from .command import (MachineError, ModelError, ParticipantError, ProtocolError, RicochetError, SceneError, UnstableError,
                      check, draw, run, study)
from .result import Result, Study

__all__ = ["run", "check", "draw", "study", "Result", "Study", "RicochetError", "SceneError", "UnstableError", "ParticipantError",
           "ProtocolError", "ModelError", "MachineError"]
