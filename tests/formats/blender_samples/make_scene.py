"""Makes scene.glb and render/: the same animated scene as Blender exports it and as Cycles renders it.

usage: blender --background --factory-startup --python make_scene.py -- FOLDER
A textured box turns and moves, a tube bends by two bones, a pyramid morphs, a floor keeps still, and the camera flies.
"""
import json
import math
import pathlib
import sys

import bpy

out = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = 10
scene.frame_start, scene.frame_end = 0, 4


def material(name, color, image=None):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    if image:
        texture = made.node_tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        made.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    return made


def key(thing, path, values, index=-1):
    for frame, value in values:
        setattr(thing, path, value)
        thing.keyframe_insert(path, frame=frame)


checker = bpy.data.images.new("checker", 8, 8)
checker.pixels = [v for y in range(8) for x in range(8) for v in ((1, 0.2, 0.1, 1) if (x + y) % 2 else (0.1, 0.3, 1, 1))]
checker.pack()

bpy.ops.mesh.primitive_plane_add(size=4, location=(0, 0, 0))
bpy.context.object.name = "floor"
bpy.context.object.data.materials.append(material("grey", (0.5, 0.5, 0.5)))

bpy.ops.mesh.primitive_cube_add(size=0.5)
box = bpy.context.object
box.name = "box"
box.data.materials.append(material("checkered", (1, 1, 1), checker))
key(box, "location", [(0, (-0.6, 0, 0.5)), (4, (-0.3, 0.2, 0.7))])
key(box, "rotation_euler", [(0, (0, 0, 0)), (4, (0.4, 0.2, 0.9))])

bpy.ops.mesh.primitive_cone_add(vertices=4, radius1=0.3, depth=0.5, location=(0.7, 0.3, 0.3))
pyramid = bpy.context.object
pyramid.name = "pyramid"
pyramid.data.materials.append(material("green", (0.1, 0.6, 0.1)))
pyramid.shape_key_add(name="base")
tall = pyramid.shape_key_add(name="tall")
for point in tall.data:
    if point.co.z > 0:
        point.co.z += 0.5
for frame, value in [(0, 0), (4, 1)]:
    tall.value = value
    tall.keyframe_insert("value", frame=frame)

bpy.ops.mesh.primitive_cylinder_add(vertices=8, radius=0.12, depth=1, location=(0.1, 0, 0.55))
tube = bpy.context.object
tube.name = "tube"
tube.data.materials.append(material("ochre", (0.7, 0.4, 0.1)))
bpy.ops.object.mode_set(mode="EDIT")
bpy.ops.mesh.select_all(action="SELECT")
bpy.ops.mesh.bisect(plane_co=(0.1, 0, 0.55), plane_no=(0, 0, 1))
bpy.ops.object.mode_set(mode="OBJECT")
bpy.ops.object.armature_add(location=(0.1, 0, 0.05))
rig = bpy.context.object
bpy.ops.object.mode_set(mode="EDIT")
lower = rig.data.edit_bones[0]
lower.name = "lower"
lower.head, lower.tail = (0, 0, 0), (0, 0, 0.5)
upper = rig.data.edit_bones.new("upper")
upper.head, upper.tail, upper.parent = (0, 0, 0.5), (0, 0, 1), lower
bpy.ops.object.mode_set(mode="OBJECT")
for name, wanted in (("lower", lambda z: z < -0.01), ("upper", lambda z: z > 0.01)):
    group = tube.vertex_groups.new(name=name)
    for vertex in tube.data.vertices:
        group.add([vertex.index], 1.0 if wanted(vertex.co.z) else (0.5 if abs(vertex.co.z) <= 0.01 else 0.0), "REPLACE")
tube.modifiers.new("rig", "ARMATURE").object = rig
world = tube.matrix_world.copy()
tube.parent = rig
tube.matrix_world = world
bone = rig.pose.bones["upper"]
bone.rotation_mode = "QUATERNION"
for frame, angle in [(0, 0.0), (4, 0.9)]:
    bone.rotation_quaternion = (math.cos(angle / 2), math.sin(angle / 2), 0, 0)
    bone.keyframe_insert("rotation_quaternion", frame=frame)

bpy.ops.object.camera_add(location=(0.2, -3, 1.4), rotation=(1.25, 0, 0.05))
camera = bpy.context.object
camera.name = "camera"
camera.data.sensor_fit = "VERTICAL"
camera.data.angle = math.radians(45)
scene.camera = camera
key(camera, "location", [(0, (0.2, -3, 1.4)), (4, (0.5, -2.8, 1.5))])
for action in bpy.data.actions:
    for curve in action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"

bpy.ops.export_scene.gltf(filepath=str(out / "scene.glb"), export_cameras=True, export_frame_range=True,
                          export_force_sampling=True, export_animations=True, export_morph=True,
                          export_nla_strips=False, export_yup=True)

scene.render.engine = "CYCLES"
scene.cycles.samples = 1
scene.cycles.filter_width = 0.01
scene.cycles.use_denoising = False
scene.cycles.max_bounces = 0
scene.render.resolution_x, scene.render.resolution_y = 64, 48
scene.render.resolution_percentage = 100
scene.view_layers[0].use_pass_z = True
scene.view_layers[0].name = "ViewLayer"
scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
scene.render.image_settings.color_depth = "32"
scene.render.image_settings.exr_codec = "ZIP"
focal = 24 / math.tan(camera.data.angle / 2)
(out / "render").mkdir(exist_ok=True)
(out / "render/intrinsics.json").write_text(
    json.dumps({"fx": focal, "fy": focal, "cx": 31.5, "cy": 23.5, "width": 64, "height": 48, "fps": 5}) + "\n")
for frame in (0, 2, 4):
    scene.frame_set(frame)
    scene.render.filepath = str(out / "render" / f"{frame:04d}.exr")
    bpy.ops.render.render(write_still=True)
