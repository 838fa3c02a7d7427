"""Dyads and linkages to look at: still drawings, and scenes that move on a page."""

import warnings

try:
    with warnings.catch_warnings():  # about meshcat's server, which is not used here
        warnings.simplefilter("ignore", DeprecationWarning)
        import meshcat  # noqa: F401

    from kinlib.pictures.bond_diagram import draw_bonds
    from kinlib.pictures.canvas import plane_axes, space_axes
    from kinlib.pictures.colours import (
        BLUE,
        GREEN,
        GREY,
        INK,
        ORANGE,
        PURPLE,
        SILVER,
        SKY,
        VERMILION,
        YELLOW,
        link_colours,
        link_names,
    )
    from kinlib.pictures.controls import Choice, Pad, Samples, Slider, Turn
    from kinlib.pictures.draw import (
        draw_curve,
        draw_frames,
        draw_hyperboloid,
        draw_line,
        draw_linkage,
        draw_linkages,
        draw_path,
        draw_positions,
        on_hyperboloid,
        write_picture,
    )
    from kinlib.pictures.explorable import ExplorableScene, Seen, Trail, explorable_scene
    from kinlib.pictures.explorable_5r import goldberg_scene, linkage_seen, map_scene
    from kinlib.pictures.explorable_samples import sampled_linkages_scene
    from kinlib.pictures.formula import Formula, record
    from kinlib.pictures.joint_angles import draw_joint_angles
    from kinlib.pictures.moving import dyad_scene, linkage_scene, linkages_side_by_side
    from kinlib.pictures.page import static_files
    from kinlib.pictures.parts import Ball, Curve, Frame, Label, Rod, Surface
    from kinlib.pictures.scene import Scene, SceneGrid
    from kinlib.pictures.tasks import task_scene
except ModuleNotFoundError as error:
    missing = (error.name or "").partition(".")[0]
    if missing not in ("PIL", "matplotlib", "meshcat", "mpl_toolkits"):
        raise
    raise ImportError(f'kinlib.pictures needs {missing}: pip install "kinlib[pictures]"') from error

__all__ = [
    "BLUE",
    "GREEN",
    "GREY",
    "INK",
    "ORANGE",
    "PURPLE",
    "SILVER",
    "SKY",
    "VERMILION",
    "YELLOW",
    "Ball",
    "Choice",
    "Curve",
    "ExplorableScene",
    "Formula",
    "Frame",
    "Label",
    "Pad",
    "Rod",
    "Samples",
    "Scene",
    "SceneGrid",
    "Seen",
    "Slider",
    "Surface",
    "Trail",
    "Turn",
    "draw_bonds",
    "draw_curve",
    "draw_frames",
    "draw_hyperboloid",
    "draw_joint_angles",
    "draw_line",
    "draw_linkage",
    "draw_linkages",
    "draw_path",
    "draw_positions",
    "dyad_scene",
    "explorable_scene",
    "goldberg_scene",
    "link_colours",
    "link_names",
    "linkage_scene",
    "linkage_seen",
    "linkages_side_by_side",
    "map_scene",
    "on_hyperboloid",
    "plane_axes",
    "record",
    "sampled_linkages_scene",
    "space_axes",
    "static_files",
    "task_scene",
    "write_picture",
]
