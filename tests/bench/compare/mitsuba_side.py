"""Renders an exported scene (export_scene.h) with Mitsuba 3.

Reads requests as JSON lines, so that the scene is loaded once: {"view", "spp", "seed", "depth", "integrator",
"out"}.
Answers each with its CPU seconds of rendering alone. Arguments: folder, variant, threads.
"""
import json
import math
import os
import resource
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402
from harness import sky_with_sun  # noqa: E402


def cpu_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def rgb(values):
    return {'type': 'rgb', 'value': [float(v) for v in values]}


def bsdf(m):
    base = np.clip(m['base_color'], 0, 1)
    if m['transmission'] > 0.99 and m['roughness'] == 0:
        kind = 'thindielectric' if m['thin_walled'] else 'dielectric'
        return {'type': kind, 'int_ior': m['ior'], 'ext_ior': 1.0}
    if m['metallic'] == 0 and m['specular'] == 0 and m['transmission'] == 0:
        return {'type': 'twosided', 'inner': {'type': 'diffuse', 'reflectance': rgb(base)}}
    if m['metallic'] == 1 and base.min() == 1:
        return {'type': 'twosided', 'inner': {'type': 'roughconductor', 'material': 'none',
                                              'distribution': 'ggx', 'alpha': m['roughness'] ** 2}}
    principled = {'type': 'principled', 'base_color': rgb(base), 'metallic': m['metallic'],
                  'roughness': max(m['roughness'], 0.03), 'sheen': m['sheen'], 'clearcoat': m['clearcoat'],
                  'clearcoat_gloss': 1 - m['clearcoat_roughness'], 'spec_trans': m['transmission']}
    if m['transmission'] > 0:
        principled['eta'] = m['ior']
        return principled
    principled['specular'] = max(m['specular'], 0.01)
    return {'type': 'twosided', 'inner': principled}


def load(folder):
    with open(os.path.join(folder, 'scene.json')) as file:
        scene = json.load(file)
    described = {'type': 'scene'}
    for i, m in enumerate(scene['materials']):
        described[f'material_{i}'] = {**bsdf(m), 'id': f'material_{i}'}
    for i, mesh in enumerate(scene['meshes']):
        shape = {'type': 'ply', 'filename': os.path.join(folder, mesh['file']),
                 'bsdf': {'type': 'ref', 'id': f'material_{mesh["material"]}'}}
        if mesh['emission']:
            shape['face_normals'] = True
            shape['emitter'] = {'type': 'area', 'radiance': rgb(mesh['emission'])}
        described[f'mesh_{i}'] = shape
    for i, point in enumerate(scene['points']):
        described[f'point_{i}'] = {'type': 'point', 'position': point['position'],
                                   'intensity': rgb(point['intensity'])}
    if scene['sky']:
        # Mitsuba's map has y up and its u runs from -z to +x.
        turn = mi.ScalarTransform4f([[0, 0, -1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
        described['sky'] = {'type': 'envmap', 'to_world': turn,
                            'bitmap': mi.Bitmap(sky_with_sun(scene, folder))}
    return scene, mi.load_dict(described)


def sensor(camera):
    columns = np.eye(4)
    for k, (axis, sign) in enumerate((('right', -1), ('down', -1), ('forward', 1))):
        columns[:3, k] = sign * np.array(camera[axis])
    columns[:3, 3] = camera['origin']
    return mi.load_dict({
        'type': 'perspective', 'to_world': mi.ScalarTransform4f(columns), 'near_clip': 0.01,
        'fov_axis': 'x', 'fov': 2 * math.degrees(math.atan(camera['width'] / (2 * camera['fx']))),
        'principal_point_offset_x': camera['cx'] / camera['width'] - 0.5,
        'principal_point_offset_y': camera['cy'] / camera['height'] - 0.5,
        'sampler': {'type': 'multijitter'},
        'film': {'type': 'hdrfilm', 'width': camera['width'], 'height': camera['height'],
                 'pixel_format': 'rgb', 'component_format': 'float32', 'rfilter': {'type': 'box'}}})


def main():
    folder, variant, threads = sys.argv[1], sys.argv[2], int(sys.argv[3])
    mi.set_variant(variant)
    dr.set_thread_count(threads)
    mi.set_log_level(mi.LogLevel.Error)
    description, scene = load(folder)
    warm = set()
    print(json.dumps({'ready': True}), flush=True)
    for request in sys.stdin:
        request = json.loads(request)
        camera = next(c for c in description['cameras'] if c['rig'] == request['view'] and c['eye'] == 0)
        integrator = mi.load_dict({'type': 'aov', 'aovs': 'albedo:albedo,normal:sh_normal',
                                   'image': {'type': request['integrator'], 'max_depth': request['depth']}})
        at = sensor(camera)

        def render(spp, seed):
            return np.array(mi.render(scene, sensor=at, integrator=integrator, spp=spp, seed=seed))
        if variant.startswith('llvm') and request['depth'] not in warm:
            render(4, 0)  # Compiles: many pictures share that.
            warm.add(request['depth'])
        start = cpu_seconds()
        image, done = None, 0
        while done < request['spp']:  # In parts: a wavefront of all samples would need gigabytes.
            count = min(64, request['spp'] - done)
            part = render(count, request['seed'] * 1000 + done) * count
            image, done = part if image is None else image + part, done + count
        image /= done
        spent = cpu_seconds() - start
        for name, first in (('color', 0), ('albedo', 3), ('normal', 6)):
            np.nan_to_num(image[..., first:first + 3]).astype(np.float32).tofile(f'{request["out"]}_{name}.f32')
        print(json.dumps({'cpu_s': spent}), flush=True)


main()
