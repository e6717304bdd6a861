"""Every perturbation, with its default magnitude."""

from scenarios.perturbation.perturbation import AtTime, Perturbation, table

# fmt: off
AT_TASKS = table(
    ("grasp-missed-above", "led_astray:GraspMissedAbove", 0.008, 0.012,
     "m above the infundibulum", "the grasper has closed too high on the gallbladder"),
    ("grasp-missed-below", "led_astray:GraspMissedBelow", 0.008, 0.012,
     "m below the infundibulum", "the grasper has closed too low on the gallbladder"),
    ("wrong-tube", "led_astray:WrongTube", 1.0, 1.0,
     "share of the way to the other tube", "the applier's jaws are around the other tube"),
    ("both-tubes", "led_astray:BothTubes", 1.0, 1.0,
     "share of the way to the middle of both tubes", "the applier's jaws are around both tubes"),
    ("overshoot", "led_astray:Overshoot", 0.004, 0.008,
     "m past the tube", "the applier has gone too far past the tube"),
    ("clip-dropped", "slips:ClipDropped", 1, 5,
     "clips in a row", "the applier loses its clip near the tube"),
    ("grasp-slip", "slips:GraspSlip", 1.0, 1.0,
     "share of the jaws' friction lost", "the gallbladder slips out of the grasper"),
)
"""Failures that strike in one of the tasks of a cholecystectomy."""

PERTURBATIONS = AT_TASKS + table(
    ("breathing", "body:Breathing", 0.002, 0.020,
     "m of amplitude", "the body moves to and fro under the instruments"),
    ("camera-shift", "picture:CameraShift", 0.005, 0.030,
     "m", "the endoscope is moved in the course of the operation"),
    ("camera-turn", "picture:CameraTurn", 0.1, 0.5,
     "rad", "the endoscope is turned in the course of the operation"),
    ("latency", "signals:Latency", 5, 60,
     "control steps of 1/30 s", "actions reach the robot late"),
    ("stiff-tissue", "body:StiffTissue", 0.5, 1.0,
     "share of the way to the stiffest possible", "tissue stiffer than in any training patient"),
    ("soft-tissue", "body:SoftTissue", 0.5, 1.0,
     "share of the way to the softest possible", "tissue softer than in any training patient"),
    ("wide-tubes", "body:WideTubes", 0.7, 1.0,
     "share of the way to the widest possible",
     "duct and artery wider than in any textbook patient"),
    ("short-tubes", "body:ShortTubes", 0.2, 1.0,
     "share of the way to the shortest possible",
     "a textbook patient's duct and artery, shortened"),
    ("large-gallbladder", "body:LargeGallbladder", 0.4, 1.0,
     "share of the way to the largest possible", "a textbook patient's gallbladder, enlarged"),
    ("dye", "picture:Dye", 0.3, 1.0,
     "share of the tissue's surface", "red liquid covers part of the tissue"),
)

SENSING = table(
    ("point-jitter", "signals:SensorError", 0.0005, 0.001,
     "m, standard deviation", "points flicker: each look has other errors"),
    ("point-bias", "signals:SensorError", 0.001, 0.003,
     "m, standard deviation", "all points are shifted together, for the whole episode"),
    ("point-dropout", "signals:SensorError", 0.25, 0.5,
     "share of looks", "points that are in sight are not found"),
    ("sensing-delay", "signals:SensorError", 0.15, 0.3,
     "s", "looks arrive late"),
    ("hand-eye", "signals:SensorError", 0.001, 0.003,
     "m, standard deviation", "the arms' places relative to the endoscope are wrong"),
)
"""Errors of the sense `tracked`; another sense refuses them."""

PICTURES = table(
    ("smoke", "picture:Smoke", 0.3, 0.8,
     "share of the light", "smoke before all cameras"),
    ("lens-blood", "picture:LensBlood", 0.15, 0.5,
     "share of the picture", "blood on all lenses"),
    ("dim-light", "picture:DimLight", 0.5, 0.9,
     "share of the light lost", "all lamps shine weakly"),
    ("wrist-blind", "picture:WristBlind", 1, 2,
     "cameras", "the wrists' cameras are off, first the right one"),
)
"""Faults of the pictures, for the sense `cameras`; another sense refuses them."""

MANUAL: dict[str, Perturbation] = {p.name: p for p in table(
    ("nudge the tissue", "body:Nudge", 0.006, 0.02, "m",
     "the body is pushed aside and swings back"),
    ("drop the clip", "slips:Drop", 1.0, 1.0, "clips", "the applier loses its clip"),
    ("shift the camera", "picture:CameraShift", 0.006, 0.02, "m", "the endoscope is bumped aside"),
    at=AtTime(time_s=0.0),
)}
"""Disturbances that a person can apply by a button, by the words on it."""
# fmt: on
