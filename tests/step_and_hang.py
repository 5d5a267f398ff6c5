"""A client process that opens, says so, and takes one step that its server never ends. Tests kill it.

python step_and_hang.py ENDPOINT
"""

import sys

from comotion_protocol import MotionClient

motion = MotionClient.open("test", sys.argv[1])
print("open", flush=True)  # noqa: T201
motion.step(0.5)
