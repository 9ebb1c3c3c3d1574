"""A virtual environment outside of the tree with pinned packages, and the program again inside of it."""
import os
import subprocess
import sys


def enter(name, packages):
    """Returns inside of the environment `name`; makes it first if it is missing."""
    cache = os.environ.get('XDG_CACHE_HOME', os.path.expanduser('~/.cache'))
    folder = os.path.join(cache, 'parallax', name)
    python = os.path.join(folder, 'bin', 'python')
    if os.path.realpath(sys.prefix) == os.path.realpath(folder):
        return
    stamp = os.path.join(folder, 'packages.txt')
    wanted = '\n'.join(packages)
    if not os.path.exists(stamp) or open(stamp).read() != wanted:
        print(f'making {folder} with {", ".join(packages)}', file=sys.stderr)
        subprocess.run([sys.executable, '-m', 'venv', folder], check=True)
        done = subprocess.run([python, '-m', 'pip', 'install', '--quiet', '--disable-pip-version-check',
                               '--only-binary', ':all:', *packages])
        if done.returncode:
            sys.exit(f'pip could not install {", ".join(packages)} into {folder} (network? Python 3.11?)')
        with open(stamp, 'w') as file:
            file.write(wanted)
    os.execv(python, [python, *sys.argv])
