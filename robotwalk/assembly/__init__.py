"""The composition root: the one room that locomotion, servos and simulator all enter.

What needs the simulator or the vendors' SDKs is imported when it is first asked for: a loop's process locks into memory
all that it has imported, and asks for none of it.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from hal.imu.model import ImuModel as ImuModel
from robotwalk.assembly.blueprint import Blueprint as Blueprint
from robotwalk.assembly.blueprint import load as load
from robotwalk.assembly.blueprint import load_gaits as load_gaits
from robotwalk.assembly.blueprint import load_servo as load_servo
from robotwalk.assembly.connected import attach as attach
from robotwalk.assembly.connected import connect as connect
from robotwalk.assembly.loads import BusLoad as BusLoad
from robotwalk.assembly.loads import SupplyLoad as SupplyLoad
from robotwalk.assembly.loads import bus_loads as bus_loads
from robotwalk.assembly.loads import supply_load as supply_load
from robotwalk.assembly.own_device import own_device as own_device
from robotwalk.assembly.session import RATE_HZ as RATE_HZ
from robotwalk.assembly.session import LocalSession as LocalSession
from robotwalk.assembly.session import Session as Session
from robotwalk.assembly.session import add_black_box as add_black_box
from robotwalk.assembly.session import check_rate as check_rate

if TYPE_CHECKING:
    from robotwalk.assembly.bus_bench import measure_bus as measure_bus
    from robotwalk.assembly.loop_bench import LoopFigures as LoopFigures
    from robotwalk.assembly.loop_bench import measure_loop as measure_loop
    from robotwalk.assembly.simulated import FLAT as FLAT
    from robotwalk.assembly.simulated import Simulation as Simulation
    from robotwalk.assembly.simulated import bare_physics as bare_physics
    from robotwalk.assembly.simulated import befall as befall
    from robotwalk.assembly.simulated import check_film as check_film
    from robotwalk.assembly.simulated import film as film
    from robotwalk.assembly.simulated import load_terrain as load_terrain
    from robotwalk.assembly.simulated import serve as serve
    from robotwalk.assembly.simulated import simulate as simulate
    from robotwalk.assembly.simulated import simulated_robot as simulated_robot
    from robotwalk.assembly.simulated import viewer as viewer
    from sim_backend.adapter import AdapterName as AdapterName  # which the command line offers
    from sim_backend.faults.script import Script as Script
    from sim_backend.faults.script import explain_faults as explain_faults
else:
    _LATER = {
        "robotwalk.assembly.bus_bench": ("measure_bus",),
        "robotwalk.assembly.loop_bench": ("LoopFigures", "measure_loop"),
        "robotwalk.assembly.simulated": (
            "FLAT", "Simulation", "bare_physics", "befall", "check_film", "film", "load_terrain", "serve", "simulate",
            "simulated_robot", "viewer"),
        "sim_backend.adapter": ("AdapterName",),
        "sim_backend.faults.script": ("Script", "explain_faults"),
    }
    _MODULES = {name: module for module, names in _LATER.items() for name in names}

    def __getattr__(name):
        """Import what is asked for."""
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(import_module(_MODULES[name]), name)
