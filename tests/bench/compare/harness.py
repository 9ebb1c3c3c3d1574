"""What vs_mitsuba and vs_cycles share: virtual environments, our programs, errors, pictures.

Runs inside the virtual environment (numpy). The other renderer runs in processes of its own, so that
its CPU seconds are its own.
"""
import argparse
import hashlib
import json
import math
import os
import struct
import subprocess
import sys
import zlib

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
PROGRAM = os.path.join(ROOT, 'build', 'release', 'bin', 'compare_scene')


def say(text):
    print(text, file=sys.stderr, flush=True)


def arguments(what, default_out):
    parser = argparse.ArgumentParser(description=what)
    parser.add_argument('--scene', default='solve:7', help='recipe (.pb) or solve:SEED[:CONFIG]')
    parser.add_argument('--size', default='480x270')
    parser.add_argument('--views', default='0,10', help='rigs whose left images are compared')
    parser.add_argument('--rigs', type=int, default=20, help='rigs that share our cost')
    parser.add_argument('--samples', type=int, default=0, help="of a pixel of ours; 0: the default profile's")
    parser.add_argument('--reference-spp', type=int, default=192,
                        help='of each of the two independent references of either renderer')
    parser.add_argument('--ladder', default='2,4,8,16,32,64,128,256',
                        help='sample counts tried with denoising until the error is ours')
    parser.add_argument('--depth', type=int, default=33,
                        help="the other renderer's longest path; 33 is what our reference has")
    parser.add_argument('--threads', type=int, default=2)
    parser.add_argument('--reference-dir', help='keeps references for the next time')
    parser.add_argument('--out', default=os.path.join(default_folder(), default_out),
                        help='where pictures and arrays are kept')
    return parser


def default_folder():
    return os.path.join(os.environ.get('XDG_CACHE_HOME', os.path.expanduser('~/.cache')), 'parallax')


def ours(*args):
    """Runs compare_scene; its JSON line, if it prints one."""
    if not os.path.exists(PROGRAM):
        sys.exit(f'{PROGRAM} is missing: ninja -C build/release compare_scene')
    result = subprocess.run([PROGRAM, *map(str, args)], capture_output=True, text=True)
    if result.returncode:
        sys.exit(result.stderr.strip())
    return json.loads(result.stdout) if result.stdout.strip() else None


def floats(path, shape):
    return np.fromfile(path, np.float32).reshape(shape)


def sky_with_sun(scene, folder):
    """The latitude-longitude map of scene.json with the sun's disk in it; rows from +z."""
    sky = scene['sky']
    image = floats(os.path.join(folder, sky['file']), (sky['height'], sky['width'], 3)).copy()
    if scene['sun'] is None:
        return image
    fine = 4
    h, w = sky['height'] * fine, sky['width'] * fine
    to = np.array(scene['sun']['direction'])
    theta = math.acos(to[2])
    rows = np.arange(max(0, int((theta - 0.03) / math.pi * h)) // fine * fine,
                     min(h, (int((theta + 0.03) / math.pi * h) // fine + 1) * fine))
    t = np.pi * (rows + 0.5) / h
    p = 2 * np.pi * (np.arange(w) + 0.5) / w
    cosine = (np.sin(t)[:, None] * (np.cos(p) * to[0] + np.sin(p) * to[1])[None] +
              (np.cos(t) * to[2])[:, None])
    inside = (cosine > math.cos(scene['sun']['radius_rad'])).astype(np.float64)
    covered = inside.reshape(len(rows) // fine, fine, w // fine, fine).mean((1, 3))
    first = rows[0] // fine
    middle = np.pi * (first + np.arange(covered.shape[0]) + 0.5) / sky['height']
    weight = (covered * np.sin(middle)[:, None]).sum() * np.pi / sky['height'] * 2 * np.pi / sky['width']
    image[first:first + covered.shape[0]] += (
        covered[..., None] * np.array(scene['sun']['irradiance']) / weight).astype(np.float32)
    return image


def levels_of(first, second, exposure):
    """8-bit levels, unrounded, of what two noisy runs agree on. A noisy pixel looks darker than it is, for the
    curve is bent; the jackknife takes that back."""
    return 2 * tone_map((first + second) / 2, exposure) - (tone_map(first, exposure) + tone_map(second, exposure)) / 2


def tone_map(radiance, exposure):
    """8-bit levels as worker/render/exposure makes them, unrounded."""
    x = np.maximum(radiance * exposure, 0)
    knee = 0.6
    x = np.where(x > knee, 1 - (1 - knee) * np.exp(-(x - knee) / (1 - knee)), x)
    srgb = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)
    return np.clip(srgb, 0, 1) * 255


def cross_error(image, first, second):
    """Mean squared error against what two independent noisy references agree on: their noise is not in it."""
    image, first, second = (np.asarray(x, np.float64) for x in (image, first, second))
    return float(((image - first) * (image - second)).mean())


def psnr(mse):
    return 10 * math.log10(255 ** 2 / max(mse, 1e-9))


def write_png(path, image):
    image = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    rows = b''.join(b'\0' + row.tobytes() for row in image)

    def chunk(kind, data):
        body = kind + data
        return struct.pack('>I', len(data)) + body + struct.pack('>I', zlib.crc32(body))

    with open(path, 'wb') as file:
        file.write(b'\x89PNG\r\n\x1a\n' +
                   chunk(b'IHDR', struct.pack('>IIBBBBB', image.shape[1], image.shape[0], 8, 2, 0, 0, 0)) +
                   chunk(b'IDAT', zlib.compress(rows, 6)) + chunk(b'IEND', b''))


def blur(image, radius):
    """Box mean of (2 radius + 1)^2 pixels, smaller at the border."""
    def along(x, axis):
        x = np.moveaxis(x, axis, 0)
        total = np.concatenate([np.zeros_like(x[:1]), np.cumsum(x, 0)])
        n = x.shape[0]
        high = np.minimum(np.arange(n) + radius + 1, n)
        low = np.maximum(np.arange(n) - radius, 0)
        mean = (total[high] - total[low]) / (high - low).reshape(-1, *[1] * (x.ndim - 1))
        return np.moveaxis(mean, 0, axis)
    return along(along(image.astype(np.float64), 0), 1)


def difference_picture(first_a, first_b, second_a, second_b):
    """Red where the first is brighter, blue where the second is; full colour at 10 % of the local brightness.
    Blurred as little as makes two runs of one renderer agree to 2 %: what is left to see is structure."""
    luminance = np.array([0.2126, 0.7152, 0.0722])
    fa, fb, sa, sb = (x.astype(np.float64) @ luminance for x in (first_a, first_b, second_a, second_b))
    # One bright sample must not stain its surroundings: cut at 8 times the local mean of all four.
    limit = 8 * blur((fa + fb + sa + sb) / 4, 8)
    fa, fb, sa, sb = (np.minimum(x, limit) for x in (fa, fb, sa, sb))
    for radius in (2, 4, 6, 8, 12, 16):
        mean = np.maximum(blur((fa + fb + sa + sb) / 4, radius), 0.05 * fa.mean())
        noise = np.median(np.abs(blur(fa - fb + sa - sb, radius)) / (2 * mean))
        if noise < 0.02:
            break
    relative = blur(fa + fb - sa - sb, radius) / (2 * mean)
    t = np.clip(relative / 0.1, -1, 1)[..., None]
    white = np.ones(3)
    colour = np.where(t > 0, white + t * (np.array([0.8, 0.1, 0.1]) - white),
                      white - t * (np.array([0.1, 0.2, 0.8]) - white))
    return colour * 255


def relative_difference(first, second):
    """By how much the mean of the first runs' pictures exceeds the second's, and its standard error."""
    a, b = (np.array([image.mean(dtype=np.float64) for image in images]) for images in (first, second))
    errors = [x.std(ddof=1) / math.sqrt(len(x)) / x.mean() for x in (a, b)]
    return float(a.mean() / b.mean() - 1), float(math.hypot(*errors))


def differing_blocks(first_a, first_b, second_a, second_b, side=16):
    """Share of blocks whose means differ by more than 3 % and 5 standard errors."""
    def means(image):
        luminance = image.astype(np.float64) @ np.array([0.2126, 0.7152, 0.0722])
        h, w = luminance.shape[0] // side * side, luminance.shape[1] // side * side
        return luminance[:h, :w].reshape(h // side, side, w // side, side).mean((1, 3))
    fa, fb, sa, sb = means(first_a), means(first_b), means(second_a), means(second_b)
    first, second = (fa + fb) / 2, (sa + sb) / 2
    error = np.sqrt(((fa - fb) ** 2 + (sa - sb) ** 2) / 4)
    pooled = np.sqrt((blur(error ** 2, 1)))  # Two runs give a poor error by themselves.
    wanted = np.maximum((first + second) / 2, 0.05 * (first + second).mean() / 2)
    return float((np.abs(first - second) > 0.03 * wanted + 5 * pooled).mean())


def match_samples(measured, wanted):
    """measured: [(spp, mse)] rising in spp. The count where the error is `wanted`, by interpolation in
    logarithms, or where it comes nearest; and whether it lies within what was measured."""
    for (n0, e0), (n1, e1) in zip(measured, measured[1:]):
        if e0 >= wanted >= e1:
            t = math.log(e0 / wanted) / max(math.log(e0 / e1), 1e-9)
            return n0 * (n1 / n0) ** t, True
    if measured and measured[0][1] < wanted:
        return float(measured[0][0]), False
    return float(min(measured, key=lambda m: m[1])[0]), False


def line(samples, seconds):
    """Seconds = a + b * samples, least squares; a not negative."""
    n = np.array(samples, float)
    s = np.array(seconds, float)
    b, a = np.polyfit(n, s, 1) if len(n) > 1 else (s[0] / n[0], 0.0)
    if a < 0:
        a, b = 0.0, float((n * s).sum() / (n * n).sum())
    return float(a), float(b)


class References:
    """Converged pictures, kept in --reference-dir if there is one."""

    def __init__(self, options, recipe):
        self.folder = options.reference_dir
        with open(recipe, 'rb') as file:
            what = file.read() + repr((options.reference_spp, options.depth)).encode()
        self.key = hashlib.sha256(what).hexdigest()[:16]

    def get(self, name, make):
        if not self.folder:
            return make()
        path = os.path.join(self.folder, f'{self.key}_{name}.npy')
        if not os.path.exists(path):
            os.makedirs(self.folder, exist_ok=True)
            np.save(path + '.part.npy', make())
            os.rename(path + '.part.npy', path)
        return np.load(path)

    def pair(self, name, make, exposure):
        """Levels of two independent references, of two runs each; make(k) -> linear picture."""
        runs = [self.get(f'{name}_{k}', lambda k=k: make(k)).astype(np.float64) for k in (1, 2, 3, 4)]
        return levels_of(runs[0], runs[1], exposure), levels_of(runs[2], runs[3], exposure)


def speed(options, folder, flavour, render_theirs):
    """The race. render_theirs(view, spp, seed, denoise) -> (linear image, cpu seconds)."""
    width, height = map(int, options.size.split('x'))
    views = [int(v) for v in options.views.split(',')]
    recipe = os.path.join(folder, 'recipe.pb')
    listed = ','.join(map(str, views))
    flavour_flag = ['--flavour', flavour]
    samples_flag = ['--spp', options.samples]
    say(f'ours: {options.rigs} rigs by the default profile')
    all_rigs = ours('render', recipe, folder, *flavour_flag, *samples_flag, '--rigs', options.rigs, '--write', listed)
    one_rig = ours('render', recipe, os.path.join(folder, 'one'), *flavour_flag, *samples_flag, '--rigs', 1)
    exposure = {v: all_rigs['exposures'][str(v)] for v in views}

    def our_picture(name, view):
        return floats(os.path.join(folder, f'{name}_{view}.f32'), (height, width, 3))

    def our_reference(view, noise):
        ours('render', recipe, folder, *flavour_flag, '--profile', 'reference', '--spp', options.reference_spp // 2,
             '--noise', noise, '--rigs', 0, '--write', view)
        return our_picture(f'reference_{noise}', view)
    references = References(options, recipe)
    our_error, their_references = {}, {}
    for v in views:
        first, second = references.pair(f'ours_{v}', lambda k, v=v: our_reference(v, k), exposure[v])
        picture = np.rint(tone_map(our_picture('default_0', v), exposure[v]))
        our_error[v] = cross_error(picture, first, second)
        write_png(os.path.join(folder, f'difference_ours_{v}.png'), 128 + 4.0 * (picture - (first + second) / 2))
        say(f'ours: view {v}: {psnr(our_error[v]):.2f} dB')
    our_mse = float(np.mean(list(our_error.values())))
    say(f'ours: {psnr(our_mse):.2f} dB, {all_rigs["cpu_s"]:.1f} CPU s for {all_rigs["pairs"]} pairs')

    for v in views:
        their_references[v] = references.pair(
            f'{os.path.basename(sys.argv[0])}_{v}',
            lambda k, v=v: render_theirs(v, options.reference_spp // 2, 100 + k, False)[0], exposure[v])
        write_png(os.path.join(folder, f'theirs_{v}.png'), sum(their_references[v]) / 2)
        say(f'theirs: references of view {v} done')
    measured, counts, seconds = [], [], []
    for spp in map(int, options.ladder.split(',')):
        errors, costs = [], []
        for v in views:
            image, cpu_s = render_theirs(v, spp, 1, True)
            picture = np.rint(tone_map(image, exposure[v]))
            errors.append(cross_error(picture, *their_references[v]))
            costs.append(cpu_s)
            write_png(os.path.join(folder, f'theirs_{spp}_{v}.png'), picture)
            write_png(os.path.join(folder, f'difference_theirs_{spp}_{v}.png'),
                      128 + 4.0 * (picture - sum(their_references[v]) / 2))
        measured.append((spp, max(float(np.mean(errors)), 1e-3)))
        counts.append(spp)
        seconds.append(float(np.mean(costs)))
        say(f'theirs: {spp} samples: {psnr(measured[-1][1]):.2f} dB, {seconds[-1]:.2f} CPU s an image')
        if measured[-1][1] < our_mse:
            break
    spp, within = match_samples(measured, our_mse)
    a, b = line(counts, seconds)
    their_cpu = a + b * spp
    our_cpu = all_rigs['cpu_s'] / (2 * all_rigs['pairs'])
    our_single = one_rig['cpu_s'] / 2
    return {'cpu_ratio': round(their_cpu / our_cpu, 2),
            'cpu_ratio_single_rig': round(their_cpu / our_single, 2),
            'matched': within,  # False: the ratio is a bound, the ladder does not reach our error.
            'spp': round(spp, 1), 'psnr_db': round(psnr(our_mse), 2),
            'their_psnr_db': [[n, round(psnr(e), 2)] for n, e in measured],
            'their_cpu_s_per_image': round(their_cpu, 2), 'our_cpu_s_per_image': round(our_cpu, 3),
            'our_cpu_s_per_image_single_rig': round(our_single, 3),
            'size': options.size, 'views': views, 'images_amortised': 2 * all_rigs['pairs'],
            'reference_spp': 2 * options.reference_spp, 'scene': options.scene}


def prepare(options, flavour, lights=''):
    folder = os.path.join(options.out, flavour)
    os.makedirs(folder, exist_ok=True)
    ours('prepare', options.scene, folder, '--size', options.size, *(['--lights', lights] if lights else []))
    ours('export', os.path.join(folder, 'recipe.pb'), folder, '--flavour', flavour)
    return folder
