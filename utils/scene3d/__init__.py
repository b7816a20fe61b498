"""Scenes in three dimensions: clouds, boxes, cars and rays, drawn with PyVista.

>>> from utils.scene3d import Scene
>>> scene = Scene("A street").add_cloud(cloud).add_clusters(points, labels).add_boxes(corners)
>>> scene.show("TopDown")
>>> scene.show(interactive=True)

No screen is needed. If PyVista is missing or cannot draw, matplotlib draws instead. The browser
draws the interactive view, without PyVista or matplotlib.
"""

from utils.scene3d.cameras import CAMERAS, Camera
from utils.scene3d.parts import LAYERS
from utils.scene3d.scene import EGO_MAXIMUM, EGO_MINIMUM, Scene

__all__ = ["CAMERAS", "EGO_MAXIMUM", "EGO_MINIMUM", "LAYERS", "Camera", "Scene"]
