"""Renders an exported scene (export_scene.h) with Blender's Cycles on the CPU.

Reads requests as JSON lines: {"view", "spp", "seed", "denoise", "out"}. Answers each with its CPU seconds
from the call that renders to its end: Blender's import and conversion of the scene is left out by rendering
once before the clock starts and keeping the data (persistent data). Arguments: folder, threads, bounces.

Indirect light is not clamped and caustics are not filtered, neither in the race nor in references, which are to be
unbiased as ours are: against these, Blender's usual settings need five times as many samples.
"""
import json
import math
import os
import resource
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bpy  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def read_ply(path):
    with open(path, 'rb') as file:
        header = b''
        while not header.endswith(b'end_header\n'):
            header += file.readline()
        words = header.split()
        vertices = int(words[words.index(b'vertex') + 1])
        faces = int(words[words.index(b'face') + 1])
        v = np.fromfile(file, np.float32, vertices * 6).reshape(-1, 6)
        f = np.fromfile(file, np.dtype([('n', 'u1'), ('v', '<i4', 3)]), faces)['v']
    return v[:, :3], f


def set_input(node, names, value):
    """Sets the first of `names` that this version of the node has."""
    for name in names:
        if name in node.inputs:
            node.inputs[name].default_value = value
            return


def material(index, m, emission):
    made = bpy.data.materials.new(f'material_{index}')
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    out = tree.nodes.new('ShaderNodeOutputMaterial')
    if emission:
        # From the front of the faces only.
        shine = tree.nodes.new('ShaderNodeEmission')
        strength = max(emission)
        shine.inputs['Color'].default_value = (*[e / strength for e in emission], 1)
        shine.inputs['Strength'].default_value = strength
        mix = tree.nodes.new('ShaderNodeMixShader')
        side = tree.nodes.new('ShaderNodeNewGeometry')
        dull = tree.nodes.new('ShaderNodeBsdfDiffuse')
        dull.inputs['Color'].default_value = (*m['base_color'], 1)
        tree.links.new(side.outputs['Backfacing'], mix.inputs[0])
        tree.links.new(shine.outputs[0], mix.inputs[1])
        tree.links.new(dull.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], out.inputs['Surface'])
        made.cycles.emission_sampling = 'FRONT'
        return made
    node = tree.nodes.new('ShaderNodeBsdfPrincipled')
    set_input(node, ['Base Color'], (*np.clip(m['base_color'], 0, 1), 1))
    set_input(node, ['Metallic'], m['metallic'])
    set_input(node, ['Roughness'], m['roughness'])
    set_input(node, ['Specular IOR Level', 'Specular'], m['specular'])
    set_input(node, ['IOR'], m['ior'] if m['transmission'] > 0 else 1.5)
    set_input(node, ['Transmission Weight', 'Transmission'], m['transmission'])
    set_input(node, ['Coat Weight', 'Clearcoat'], m['clearcoat'])
    set_input(node, ['Coat Roughness', 'Clearcoat Roughness'], m['clearcoat_roughness'])
    set_input(node, ['Sheen Weight', 'Sheen'], m['sheen'])
    if 'Thin Wall' in node.inputs:
        node.inputs['Thin Wall'].default_value = bool(m['thin_walled'])
    tree.links.new(node.outputs[0], out.inputs['Surface'])
    return made


def add_object(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def look_along(direction, position=(0, 0, 0)):
    """A lamp's matrix: lamps shine along their -z."""
    turn = Vector([-float(d) for d in direction]).to_track_quat('Z', 'Y')
    return Matrix.Translation(Vector([float(p) for p in position])) @ turn.to_matrix().to_4x4()


def load(folder):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with open(os.path.join(folder, 'scene.json')) as file:
        scene = json.load(file)
    for i, mesh in enumerate(scene['meshes']):
        positions, faces = read_ply(os.path.join(folder, mesh['file']))
        data = bpy.data.meshes.new(f'mesh_{i}')
        data.vertices.add(len(positions))
        data.vertices.foreach_set('co', positions.ravel())
        data.loops.add(faces.size)
        data.loops.foreach_set('vertex_index', faces.ravel())
        data.polygons.add(len(faces))
        data.polygons.foreach_set('loop_start', np.arange(0, faces.size, 3, dtype=np.int32))
        data.update()
        if not mesh['emission']:
            data.shade_smooth()  # Vertices are apart where edges are sharp.
        data.materials.append(material(i, scene['materials'][mesh['material']], mesh['emission']))
        add_object(f'mesh_{i}', data)
    for i, point in enumerate(scene['points']):
        lamp = bpy.data.lights.new(f'point_{i}', 'POINT')
        watts = [4 * math.pi * v for v in point['intensity']]
        lamp.energy, lamp.color = max(watts), [w / max(watts) for w in watts]
        lamp.shadow_soft_size = 0
        add_object(f'point_{i}', lamp).location = point['position']
    if scene['sun']:
        sun = bpy.data.lights.new('sun', 'SUN')
        irradiance = scene['sun']['irradiance']
        sun.energy, sun.color = max(irradiance), [v / max(irradiance) for v in irradiance]
        sun.angle = 2 * scene['sun']['radius_rad']
        add_object('sun', sun).matrix_world = look_along([-v for v in scene['sun']['direction']])
    if scene['sky']:
        sky(scene, folder)
        for i, portal in enumerate(scene['portals']):
            lamp = bpy.data.lights.new(f'portal_{i}', 'AREA')
            lamp.shape = 'RECTANGLE'
            u, v = np.array(portal['u']), np.array(portal['v'])
            lamp.size, lamp.size_y = float(np.linalg.norm(u)), float(np.linalg.norm(v))
            lamp.cycles.is_portal = True
            inward = np.cross(u, v)
            inward /= np.linalg.norm(inward)
            x = u / np.linalg.norm(u)
            matrix = np.eye(4)
            matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = x, np.cross(-inward, x), -inward
            matrix[:3, 3] = np.array(portal['corner']) + (u + v) / 2
            add_object(f'portal_{i}', lamp).matrix_world = Matrix(matrix.tolist())
    return scene


def sky(scene, folder):
    """The map without the sun, which is a lamp here. Blender's u falls with the azimuth; rows from below."""
    size = scene['sky']
    pixels = np.fromfile(os.path.join(folder, size['file']), np.float32).reshape(size['height'], size['width'], 3)
    turned = np.roll(pixels[:, ::-1], size['width'] // 2, axis=1)[::-1]
    image = bpy.data.images.new('sky', size['width'], size['height'], float_buffer=True)
    image.colorspace_settings.name = 'Linear Rec.709'
    image.pixels.foreach_set(np.concatenate([turned, np.ones_like(turned[..., :1])], 2).ravel())
    image.update()
    world = bpy.data.worlds.new('sky')
    bpy.context.scene.world = world
    world.use_nodes = True
    texture = world.node_tree.nodes.new('ShaderNodeTexEnvironment')
    texture.image = image
    world.node_tree.links.new(texture.outputs[0], world.node_tree.nodes['Background'].inputs['Color'])
    world.cycles.sampling_method = 'AUTOMATIC'


def camera(c):
    data = bpy.data.cameras.new('camera')
    thing = add_object('camera', data)
    matrix = np.eye(4)
    for k, (axis, sign) in enumerate((('right', 1), ('down', -1), ('forward', -1))):
        matrix[:3, k] = sign * np.array(c[axis])
    matrix[:3, 3] = c['origin']
    thing.matrix_world = Matrix(matrix.tolist())
    data.sensor_fit, data.sensor_width = 'HORIZONTAL', 36
    data.lens = 36 * c['fx'] / c['width']
    data.shift_x = 0.5 - c['cx'] / c['width']
    data.shift_y = (c['cy'] - 0.5 * c['height']) / c['width']
    data.clip_start, data.clip_end = 0.01, 1000
    return thing


def main():
    # Blender talks on standard output; the answers keep a channel of their own.
    answers = os.fdopen(os.dup(1), 'w')
    os.dup2(2, 1)
    folder, threads, bounces = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    description = load(folder)
    scene = bpy.context.scene
    scene.render.engine = 'CYCLES'
    scene.cycles.device = 'CPU'
    scene.render.threads_mode, scene.render.threads = 'FIXED', threads
    scene.render.use_persistent_data = True
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = 'BOX'  # One pixel wide, as ours: equally sharp pictures.
    scene.cycles.max_bounces = scene.cycles.transmission_bounces = bounces
    scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = bounces
    scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = 0
    scene.cycles.denoiser = 'OPENIMAGEDENOISE'
    scene.render.image_settings.file_format = 'OPEN_EXR'
    scene.render.image_settings.color_depth = '32'
    scene.render.image_settings.exr_codec = 'NONE'
    cameras = {c['rig']: (c, camera(c)) for c in description['cameras'] if c['eye'] == 0}
    warm = set()
    print(json.dumps({'ready': True}), file=answers, flush=True)
    for request in sys.stdin:
        request = json.loads(request)
        c, scene.camera = cameras[request['view']]
        scene.render.resolution_x, scene.render.resolution_y = c['width'], c['height']
        scene.render.resolution_percentage = 100
        scene.cycles.seed = request['seed']
        scene.cycles.use_denoising = request['denoise']
        scene.render.filepath = request['out']

        def render(samples):
            scene.cycles.samples = samples
            scene.update_tag()  # Else kept data is rendered with the settings before.
            bpy.context.view_layer.update()
            start = cpu_seconds()
            bpy.ops.render.render(write_still=True)
            return cpu_seconds() - start
        key = (request['view'], request['denoise'])
        if key not in warm:
            scene.cycles.seed = 9999
            render(1)  # Import, conversion, BVH, denoiser's weights.
            scene.cycles.seed = request['seed']
            warm.add(key)
        spent = render(request['spp'])
        image = bpy.data.images.load(request['out'])
        pixels = np.empty(c['width'] * c['height'] * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        pixels.reshape(c['height'], c['width'], 4)[::-1, :, :3].copy().tofile(request['out'] + '.f32')
        print(json.dumps({'cpu_s': spent}), file=answers, flush=True)


main()
