"""Exudyn: a mass point; drag, lift and weight by a load of the user's."""

from typing import Any

import exudyn
from exudyn import itemInterface as Items

from analysis.wild.air import push_of_air


def fly(state: Any, p: Any, method: str, step: float) -> Any:
    push, mass, points = push_of_air(state, p), p["ball.mass"], []
    system = exudyn.SystemContainer()
    mbs = system.AddSystem()
    node = mbs.AddNode(Items.NodePoint(initialCoordinates=state[:3], initialVelocities=state[3:]))
    body = mbs.AddObject(Items.MassPoint(mass=mass, nodeNumber=node))
    marker = mbs.AddMarker(Items.MarkerBodyPosition(bodyNumber=body))

    def load(mbs: Any, t: float, _: Any) -> Any:
        a = push(*mbs.systemData.GetODE2Coordinates_t())
        return [mass * a[0], mass * a[1], mass * (a[2] - p["gravity"])]

    def record(mbs: Any, t: float) -> bool:
        where = mbs.systemData
        points.append([t, *where.GetODE2Coordinates(), *where.GetODE2Coordinates_t()])
        return bool(points[-1][3] >= p["ground.height"])

    mbs.AddLoad(Items.Force(markerNumber=marker, loadVectorUserFunction=load))
    mbs.SetPostStepUserFunction(record)
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    time = settings.timeIntegration
    time.endTime, time.numberOfSteps = 60.0, round(60.0 / step)
    time.automaticStepSize, settings.solution.file.write = False, False
    time.verboseMode = 0
    mbs.SolveDynamic(settings, solverType=getattr(exudyn.DynamicSolverType, method))
    return points
