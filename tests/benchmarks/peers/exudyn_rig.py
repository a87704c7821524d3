"""The rig in Exudyn: a rigid body on spring-dampers from a frame that slides along x; runs in the peers' environment.

On standard input the rig's numbers, pins and runs; on standard output, for each run, the least seconds of several and
the positions of three points of the body and of the frame at every ``every``-th step.
"""

import json
import sys
import time

import exudyn as exu
import numpy as np
from exudyn.advancedUtilities import CreateSymbolicUserFunction
from exudyn.utilities import (
    InertiaCylinder,
    LoadCoordinate,
    MarkerBodyPosition,
    MarkerNodeCoordinate,
    Node1D,
    NodePointGround,
    NodeRigidBodyRxyz,
    ObjectConnectorCartesianSpringDamper,
    ObjectConnectorCoordinateSpringDamper,
    ObjectConnectorSpringDamper,
    ObjectMass1D,
    ObjectRigidBody,
    SensorBody,
)


def system(rig):
    """The assembled system, its sensors, of the frame, then of points of the body, and what has to live as long."""
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    ground = mbs.AddNode(NodePointGround())
    slide = mbs.AddNode(Node1D(referenceCoordinates=[0.0]))
    frame = mbs.AddObject(ObjectMass1D(mass=rig["ms"], nodeNumber=slide))
    inertia = InertiaCylinder(density=1.0, length=rig["Lm"], outerRadius=rig["Rm"], axis=0)
    inertia = inertia.InertiaCOM() * rig["m"] / inertia.Mass()
    rates = rig["rates"]
    node = mbs.AddNode(
        NodeRigidBodyRxyz(referenceCoordinates=[rig["LG"], 0, 0, 0, 0, 0], initialVelocities=[0, 0, 0, *rates])
    )
    mass = mbs.AddObject(ObjectRigidBody(
        mass=rig["m"], nodeNumber=node,
        inertia=[*np.diag(inertia), inertia[1, 2], inertia[0, 2], inertia[0, 1]],
    ))  # fmt: skip
    on = lambda body, at: mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=at))  # noqa: E731
    for *frame_pin, x, y, z, k in rig["wires"]:
        ends = [on(frame, frame_pin), on(mass, [x, y, z])]
        wire = {"stiffness": k, "damping": rig["wire_damping"], "referenceLength": rig["d0"]}
        mbs.AddObject(ObjectConnectorSpringDamper(markerNumbers=ends, **wire))
    P = [on(frame, [0, 0, 0]), on(mass, [-rig["LG"], 0, 0])]
    mbs.AddObject(ObjectConnectorCartesianSpringDamper(markerNumbers=P, damping=[rig["c"], 0, 0]))
    ends = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=n, coordinate=0)) for n in (ground, slide)]
    shaker = {"stiffness": rig["ks"], "damping": rig["cs"]}
    mbs.AddObject(ObjectConnectorCoordinateSpringDamper(markerNumbers=ends, **shaker))
    force, omega = rig["force"], 2 * np.pi * rig["frequency"]
    shake = mbs.AddLoad(LoadCoordinate(markerNumber=ends[1], load=force))
    load = lambda mbs, t, value: force * exu.symbolic.cos(omega * t)  # noqa: E731
    symbolic = CreateSymbolicUserFunction(mbs, load, "loadUserFunction", itemIndex=shake)
    mbs.SetLoadParameter(shake, "loadUserFunction", symbolic)
    weight = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=1))
    mbs.AddLoad(LoadCoordinate(markerNumber=weight, load=-rig["m"] * rig["gravity"]))
    position = exu.OutputVariableType.Position
    places = [(frame, [0, 0, 0]), *((mass, at) for at in rig["points"])]
    sensors = [
        mbs.AddSensor(SensorBody(bodyNumber=body, localPosition=at, outputVariableType=position, storeInternal=True))
        for body, at in places
    ]
    mbs.Assemble()
    return mbs, sensors, (container, symbolic)


def march(rig, method, step, every):
    """Seconds of the solver, and positions (samples, points, 3)."""
    mbs, sensors, _alive = system(rig)
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(rig["duration"] / step)
    settings.timeIntegration.endTime = rig["duration"]
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step * every
    begun = time.perf_counter()
    mbs.SolveDynamic(settings, solverType=getattr(exu.DynamicSolverType, method))
    seconds = time.perf_counter() - begun
    return seconds, np.stack([mbs.GetSensorStoredData(sensor)[:, 1:4] for sensor in sensors], axis=1)


def main():
    """Every run that is asked for."""
    rig, results = json.load(sys.stdin), []
    for method, step, every in rig.pop("runs"):
        tries = [march(rig, method, step, every) for _ in range(rig["tries"])]
        results.append({"seconds": min(seconds for seconds, _ in tries), "positions": tries[0][1].tolist()})
    json.dump(results, sys.stdout)


if __name__ == "__main__":
    main()
