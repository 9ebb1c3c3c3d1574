#!/usr/bin/env python3
"""Clicks through the page of a real farm in a headless Chromium.

page_test.py --coordinator PROGRAM --worker PROGRAM --client PROGRAM [--shots DIR]

A farm with certificates renders a tiny study whose trainer is broken, so that there are pairs, and a failed job with a
log. A stranger sees nothing; an operator opens the link that `parallax page` gives for a certificate, and clicks study ->
pair -> job -> log, pauses a study and resumes it. Then a local run shows itself with `run --page`.
Exit status 77: there is no Chromium here."""

import argparse
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from answers import check_answers, sessions_change_under_the_page  # noqa: E402
from devtools import Browser, PageError, find_chromium  # noqa: E402

SKIPPED = 77
STUDY = """study: tiny
base: indoor
seed: 5
pairs: 4
rigs_per_scene: 2
variants:
  - name: narrow
  - name: wide
    set: {{rigs: {{baseline_m: {{uniform: [0.3, 0.4]}}}}}}
{more}"""
TRAIN = "train: {trainer: broken, seeds: 1, steps: 10, only_mixtures: false}\n"
TRAINER = """trainer: broken
layout: archive
train: [sh, -c, 'echo the lamp is broken; exit 3', '{seed}']
progress: json
leaves: {checkpoints: net-*.json, final: last.json}
predict: [sh, -c, 'exit 3']
"""
SMALL = ["--width", "160", "--height", "96", "--samples", "1", "--profile", "preview"]


class Farm:
    def __init__(self, programs, folder):
        self.programs, self.folder, self.children = programs, folder, []

    def run(self, program, *arguments):
        done = subprocess.run([getattr(self.programs, program), *arguments], capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, f"{program} {' '.join(arguments)}: {done.stderr}"
        return done.stdout.strip()

    def start(self, program, *arguments):
        log = open(f"{self.folder}/{program}.log", "w")
        child = subprocess.Popen([getattr(self.programs, program), *arguments], stdout=subprocess.PIPE, stderr=log, text=True)
        self.children.append(child)
        return child

    def serve(self):
        tls = f"{self.folder}/tls"
        self.run("coordinator", "init", tls, "--issue", "worker", "pool", "--issue", "operator", "olga")
        with open(f"{self.folder}/limits.yaml", "w") as file:
            file.write("users: {operator olga: {max_running: 50, max_studies: 7}}\n")
        child = self.start("coordinator", "serve", "--db", f"{self.folder}/queue.db", "--store", f"{self.folder}/store", "--listen",
                           "127.0.0.1:0", "--http", "0.0.0.0:0", "--tls", f"{tls}/server", "--backoff-s", "0.1", "--limits",
                           f"{self.folder}/limits.yaml")
        self.address = child.stdout.readline().split()[-1]
        self.http = "127.0.0.1:" + child.stdout.readline().split(":")[-1].strip(" /\n")
        os.makedirs(f"{self.folder}/trainers")
        with open(f"{self.folder}/trainers/broken.yaml", "w") as file:
            file.write(TRAINER)
        self.start("worker", "--role", "all", "--coordinator", self.address, "--tls", f"{tls}/worker-pool", "--name", "w1", "--outbox",
                   f"{self.folder}/outbox", "--trainers", f"{self.folder}/trainers", "--allow-trainers", "broken")

    def submit(self, name, more, pairs):
        path = f"{self.folder}/{name}.yaml"
        with open(path, "w") as file:
            file.write(STUDY.format(more=more).replace("study: tiny", f"study: {name}").replace("pairs: 4", f"pairs: {pairs}"))
        self.client("submit", path, *SMALL)

    def client(self, *arguments):
        return self.run("client", *arguments, "--coordinator", self.address, "--tls", f"{self.folder}/tls/operator-olga")

    def stop(self):
        for child in self.children:
            child.send_signal(signal.SIGTERM)
        for child in self.children:
            try:
                child.wait(30)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()


def shot(page, shots, name):
    if shots:
        page.screenshot(f"{shots}/{name}.png", full=True)


def check_fits(page):
    """Nothing is cut off at the side of a phone."""
    page.size(390, 844)
    wide = page.value("document.documentElement.scrollWidth - innerWidth")
    assert wide <= 0, f"{page.value('location.hash')} is {wide} px wider than a phone"


def a_stranger_sees_nothing(browser, farm):
    page = browser.open(f"https://{farm.http}/")
    page.wait("!!document.querySelector('form input[type=password]')")
    assert "tiny" not in page.text()
    assert page.value("fetch('/api/v1/studies').then((r) => r.status)") == 401
    page.close()


def study_pair_job_log(browser, farm, shots):
    page = browser.open(farm.client("page", "--http", farm.http))
    page.wait("document.body.innerText.includes('olga')")
    assert "code" not in page.value("location.href"), "the code stays in the address"
    page.wait("[...document.querySelectorAll('.studies a')].some((a) => a.textContent === 'tiny')")
    shot(page, shots, "farm")

    page.click(".studies tr:last-child th a")
    page.wait("document.querySelector('h1').textContent === 'tiny'")
    page.wait("[...document.querySelectorAll('.thumb img')].filter((i) => i.complete && i.naturalWidth > 0).length >= 8", 90)
    page.wait("[...document.querySelectorAll('.causes li')].length > 0", 90)
    assert "broken" in page.text()
    shot(page, shots, "study")

    page.click(".thumb")
    page.wait("document.querySelector('.canvas img.front')?.naturalWidth > 0")
    page.click("button[data-view=disparity]")
    page.wait("document.querySelector('.canvas canvas')?.width === 160")
    page.move(".canvas", 0.4, 0.6)
    page.wait("/disparity [0-9.]+ px/.test(document.querySelector('.readout').innerText.replace(/\\s+/g, ' '))")
    page.wait("/depth [0-9.]+ m/.test(document.querySelector('.readout').innerText.replace(/\\s+/g, ' '))")
    shot(page, shots, "pair")
    first = page.value("location.hash")
    page.key("ArrowRight")
    page.wait(f"location.hash !== '{first}' && document.querySelector('.canvas img')?.src.includes('/pairs/' + location.hash.split('/').pop() + '/')")
    page.wait("!!document.querySelector('.classes li') && document.querySelector('.canvas img.front').complete")
    page.click("details summary")
    page.wait("document.querySelector('details pre')?.textContent.includes('scene_seed')")

    page.click(".trail a[href^='#/study']")
    page.wait("document.querySelectorAll('.causes a').length > 0")
    page.click(".causes a")
    page.wait("document.querySelector('.log')?.textContent.includes('the lamp is broken')")
    page.wait("document.querySelectorAll('.attempts li').length >= 3")
    shot(page, shots, "job")
    return page, page.value("location.hash")


def pause_and_resume(page, farm, shots):
    page.value("location.hash = '#/'")
    page.wait("[...document.querySelectorAll('.studies a')].some((a) => a.textContent === 'large')")
    page.click(".studies tr:first-child th a")
    page.click("button[data-action=pause]")
    page.wait("document.querySelector('dialog').open")
    shot(page, shots, "pause")
    page.click("button[data-confirm=pause]")
    page.wait("document.querySelector('.headline .tag').textContent === 'paused'")
    assert "paused" in farm.client("status", "large"), "the queue says otherwise"
    page.click("button[data-action=resume]")
    page.wait("document.querySelector('.headline .tag').textContent === 'running'")
    assert "https:127.0.0.1" in farm.client("audit")


def limits_are_shown_and_set(page, farm, shots):
    page.value("location.hash = '#/'")
    page.wait("document.querySelector('#users')?.closest('section').innerText.includes('operator olga')")
    page.click(".studies tr:first-child th a")
    page.click("button[data-action=limit]")
    page.wait("document.querySelector('dialog').open && document.activeElement.id === 'number'")
    page.value("document.querySelector('#number').select()")
    page.key("1", "Digit1", "1")
    shot(page, shots, "limit")
    page.click("button[data-confirm=limit]")
    page.wait("document.querySelector('#at-limit')?.textContent.includes('held back by max_running 1')")
    shot(page, shots, "at_limit")
    assert "at most 1 job at a time" in farm.client("status", "large"), "the queue says otherwise"
    assert "operator olga" in farm.client("limits")
    farm.client("limits", "large", "--max-running", "0")
    page.click("button[data-action=priority]")
    page.wait("document.querySelector('dialog').open && document.activeElement.id === 'number'")
    page.value("document.querySelector('#number').select()")
    page.key("7", "Digit7", "7")
    page.click("button[data-confirm=priority]")
    page.wait("document.querySelector('.facts').textContent.includes('priority')")
    assert "priority 7" in farm.client("status", "large"), "the queue says otherwise"
    page.wait("!document.querySelector('#at-limit')")
    page.value("location.hash = '#/'")
    page.wait("!!document.querySelector('#users')")
    shot(page, shots, "users")


def a_stream_shows_what_it_waits_for(page, farm, shots):
    path = f"{farm.folder}/drive.yaml"
    with open(path, "w") as file:
        file.write("study: drive\npairs: endless\nseed: 9\nrigs_per_scene: 2\nstream: {chunk_pairs: 4}\nvariants: [{name: rooms, base: indoor}]\n"
                   "set: {render: {profile: preview}, rigs: {width_px: 160, height_px: 96, count: 2}}\n")
    farm.client("stream", path)
    page.value("location.hash = '#/'")
    page.wait("document.querySelector('#streams')?.closest('section').innerText.includes('pairs of chunk 0')")
    farm.client("pause", "drive-0")
    page.wait("document.querySelector('#streams')?.closest('section').querySelector('.warn')?.textContent.includes('parallax resume')")
    shot(page, shots, "streams")


def a_search_shows_its_trials(page, farm, shots):
    path = f"{farm.folder}/settings.yaml"
    with open(path, "w") as file:
        file.write("study: settings\nbase: indoor\nseed: 3\npairs: 4\nrigs_per_scene: 2\n"
                   "set: {render: {profile: preview}, rigs: {width_px: 160, height_px: 96, count: 2}}\n"
                   "search:\n  space:\n    floating.count: {range: [0, 40]}\n    materials.mode: {choice: [all, none]}\n"
                   "  trials: 3\ntrain: {trainer: broken, seeds: 1, steps: 10}\nevaluate: {benchmarks: [shipped]}\n")
    farm.client("search", path)
    page.value("location.hash = '#/'")
    page.wait("document.querySelector('#searches')?.closest('section').innerText.includes('rung 1 (study ')")
    page.click("section[aria-labelledby=searches] tbody a")
    page.wait("document.querySelector('h1').textContent === 'settings'")
    page.wait("document.querySelectorAll('.trials tbody tr').length === 4")
    page.wait("document.querySelector('img.drawn')?.naturalWidth === 960")
    shot(page, shots, "search")


def all_jobs_are_reached_by_keyboard(page, shots):
    page.value("location.hash = '#/study/2/jobs?state=READY'")
    page.wait("document.querySelectorAll('.joblist tbody tr').length === 300")
    page.value("document.querySelector('button.more').focus()")
    page.key("Enter")
    page.wait("document.querySelectorAll('.joblist tbody tr').length > 300")
    page.wait("document.activeElement.id.startsWith('job-')")
    order = page.value("[...document.querySelectorAll('.joblist tbody a')].findIndex((a) => a === document.activeElement)")
    assert 280 <= order <= 300, f"the focus is on job {order} of the list"
    repeated = page.value("(() => { const all = [...document.querySelectorAll('.joblist tbody a')].map((a) => a.id);"
                          " return all.length - new Set(all).size; })()")
    assert repeated == 0, f"{repeated} jobs stand twice"
    shot(page, shots, "jobs")


def every_view_fits_and_is_reached_by_keyboard(page):
    for place in ("/", "/search/settings", "/study/1", "/study/1/jobs", "/pair/1", "/workers", "/audit"):
        page.size(1280, 860)
        page.value(f"location.hash = '#{place}'")
        # The view before it is drawn away first.
        page.value("new Promise((done) => setTimeout(() => requestAnimationFrame(() => done(1)), 300))")
        page.wait("!!document.querySelector('main h1') && !document.querySelector('[aria-busy]')")
        for step in range(2):
            page.key("Tab")
            if step > 0 and page.value("document.activeElement === document.body"):
                break  # The view has one link or button.
            ring = page.value("getComputedStyle(document.activeElement).outlineStyle")
            assert ring not in ("none", ""), f"{place}: the focus is not to be seen"
        assert page.value("document.querySelectorAll('main').length") == 1
        names = page.value("[...document.querySelectorAll('button, a, input')].filter((e) => !(e.ariaLabel || e.textContent.trim() || "
                           "e.labels?.length)).map((e) => e.outerHTML)")
        assert not names, f"{place}: without a name: {names[:3]}"
        check_fits(page)


def a_local_run_shows_itself(browser, programs, folder):
    path = f"{folder}/local.yaml"
    with open(path, "w") as file:
        file.write(STUDY.format(more="").replace("study: tiny", "study: local").replace("pairs: 4", "pairs: 40"))
    run = subprocess.Popen([programs.client, "run", path, "--out", f"{folder}/out", "--page", "--workers", "1", *SMALL],
                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        link = next(line.split()[1] for line in run.stderr if line.startswith("page: "))
        assert link.startswith("http://127.0.0.1:"), link
        page = browser.open(link)
        page.wait("[...document.querySelectorAll('.studies a')].some((a) => a.textContent === 'local')")
        page.click(".studies th a")
        page.wait("document.querySelectorAll('.thumb').length > 0", 90)
        stranger = browser.open(link)  # The same browser has the cookie: another one would be refused.
        stranger.wait("!!document.querySelector('main h1')")
        assert not [c for c in page.complaints() if "401" not in c], page.complaints()
    finally:
        run.send_signal(signal.SIGINT)
        run.send_signal(signal.SIGINT)
        for _ in run.stderr:
            pass
        run.wait(60)


def main():
    parser = argparse.ArgumentParser()
    for program in ("coordinator", "worker", "client"):
        parser.add_argument(f"--{program}", required=True)
    parser.add_argument("--shots", help="folder for screenshots")
    programs = parser.parse_args()
    if not find_chromium():
        print("skipped: there is no Chromium (apt-get install chromium, or PARALLAX_CHROMIUM=PROGRAM)")
        return SKIPPED
    folder = tempfile.mkdtemp(prefix="parallax-page-")
    farm = Farm(programs, folder)
    begin = time.monotonic()
    try:
        farm.serve()
        farm.submit("tiny", TRAIN, 4)
        with Browser(trust_any_certificate=True) as browser:
            a_stranger_sees_nothing(browser, farm)
            page, job = study_pair_job_log(browser, farm, programs.shots)
            farm.submit("large", "", 400)
            pause_and_resume(page, farm, programs.shots)
            check_answers(browser, farm, job)
            limits_are_shown_and_set(page, farm, programs.shots)
            a_stream_shows_what_it_waits_for(page, farm, programs.shots)
            a_search_shows_its_trials(page, farm, programs.shots)
            all_jobs_are_reached_by_keyboard(page, programs.shots)
            every_view_fits_and_is_reached_by_keyboard(page)
            assert not page.complaints(), page.complaints()
            sessions_change_under_the_page(browser, farm)
            a_local_run_shows_itself(browser, programs, folder)
        print(f"study -> pair -> job -> log, pause and resume: as it should be, in {time.monotonic() - begin:.0f} s")
        return 0
    except (PageError, AssertionError):
        for name in ("coordinator", "worker"):
            if os.path.exists(f"{folder}/{name}.log"):
                print(f"---- {name}\n" + open(f"{folder}/{name}.log").read()[-3000:])
        raise
    finally:
        farm.stop()
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
