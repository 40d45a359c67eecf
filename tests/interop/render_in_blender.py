"""Imports a file into Blender and draws it at some frames, from the camera of the capture.

usage: blender -b --factory-startup --python-exit-code 1 --python render_in_blender.py -- JOB.json

JOB: {"camera": {w, h, fx, fy, cx, cy}, "fps", "frames": [number], "samples": number,
      "views": [{"file": a .glb or "files": all .vdb of a sequence, z up, "out": prefix}]}; paths are absolute.
Writes <out>_<number in the list>.png. Colours as stored: view transform Standard, transparent where nothing is.
"""
import json
import math
import os
import sys

import bpy
import numpy

numpy.bool = bool  # Blender 3.4's importer names what NumPy 1.24 has removed


def empty_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


def set_up(scene, job):
    c = job["camera"]
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = job["samples"]
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.transparent_max_bounces = 64
    scene.render.film_transparent = True
    scene.render.resolution_x, scene.render.resolution_y = c["w"], c["h"]
    scene.render.resolution_percentage = 100
    scene.render.pixel_aspect_y = c["fx"] / c["fy"]
    scene.render.fps = round(job["fps"])
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGBA"
    lens = bpy.data.cameras.new("capture")
    lens.sensor_fit = "HORIZONTAL"
    lens.lens = lens.sensor_width * c["fx"] / c["w"]
    # Pixel centres lie at integers; a shift is in widths of the picture.
    lens.shift_x = 0.5 - (c["cx"] + 0.5) / c["w"]
    lens.shift_y = ((c["cy"] + 0.5) - c["h"] / 2) / c["w"]
    lens.clip_start = 0.01
    camera = bpy.data.objects.new("capture", lens)
    camera.rotation_euler = (math.pi / 2, 0, 0)  # looks along glTF's -z, which is Blender's +y
    scene.collection.objects.link(camera)
    scene.camera = camera


def volume_material():
    """The one that docs/exporting/blender.md describes: the volume shines by itself."""
    material = bpy.data.materials.new("volume")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    add = nodes.new("ShaderNodeAddShader")
    emission = nodes.new("ShaderNodeEmission")
    absorption = nodes.new("ShaderNodeVolumeAbsorption")
    absorption.inputs["Color"].default_value = (0, 0, 0, 1)
    for name in ("density", "color"):
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = name
        if name == "color":
            links.new(attribute.outputs["Color"], emission.inputs["Color"])
        else:
            links.new(attribute.outputs["Fac"], emission.inputs["Strength"])
            links.new(attribute.outputs["Fac"], absorption.inputs["Density"])
    links.new(emission.outputs[0], add.inputs[0])
    links.new(absorption.outputs[0], add.inputs[1])
    links.new(add.outputs[0], output.inputs["Volume"])
    return material


def render(scene, path):
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def draw_model(job, view):
    scene = empty_scene()
    set_up(scene, job)
    bpy.ops.import_scene.gltf(filepath=view["file"])
    for i, frame in enumerate(job["frames"]):
        scene.frame_set(frame)
        render(scene, f"{view['out']}_{i}.png")


def draw_volumes(job, view):
    scene = empty_scene()
    set_up(scene, job)
    first = view["files"][0]
    bpy.ops.object.volume_import(filepath=first, files=[{"name": os.path.basename(file)} for file in view["files"]],
                                 directory=os.path.dirname(first))
    volume = bpy.context.object.data
    if volume.is_sequence != (len(view["files"]) > 1):
        sys.exit("the files are no sequence")
    volume.materials.append(volume_material())
    for i, frame in enumerate(job["frames"]):
        scene.frame_set(volume.frame_start + frame)
        render(scene, f"{view['out']}_{i}.png")


def main():
    with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
        job = json.load(file)
    for view in job["views"]:
        (draw_volumes if "files" in view else draw_model)(job, view)


main()
