"""How the page takes answers that come late, not at all, or are refused: the test answers in the coordinator's place.

Each check opens a window of its own, in which `answers` replaces some answers of the API and `happen` sends an event."""

OWN_ANSWERS = """
window.EventSource = class {
  static OPEN = 1;
  static CLOSED = 2;
  readyState = 1;
  constructor() { window.happen = (farm) => this.heard?.({ data: JSON.stringify(farm) }); }
  addEventListener(name, heard) { this.heard = heard; }
  close() {}
};
window.answers = [];  // [pattern of the path, (path, options) => [status, body], or a promise of it].
const coordinator = window.fetch;
window.fetch = async (path, options) => {
  const own = window.answers.find(([pattern]) => pattern.test(path));
  if (!own) return coordinator(path, options);
  const [status, body] = await own[1](path, options);
  return new Response(JSON.stringify(body), { status });
};
"""


class OwnAnswers:
    def __init__(self, browser, farm, place):
        self.page = browser.open("about:blank")
        self.page.call("Page.addScriptToEvaluateOnNewDocument", {"source": OWN_ANSWERS})
        self.page.call("Page.navigate", {"url": f"https://{farm.http}/#{place}"})
        self.page.wait("document.querySelectorAll('main h1').length === 1 && !document.querySelector('[aria-busy]')")
        self.page.value("fetch('/api/v1/farm').then((r) => r.json()).then((farm) => { window.farm = farm; })")

    def __enter__(self):
        return self.page

    def __exit__(self, *_):
        self.page.close()


def a_slow_answer_arrives(browser, farm):
    """Events come more often than a slow line brings a study."""
    with OwnAnswers(browser, farm, "/") as page:
        page.value("answers.push([/studies\\/2$/, (path, { signal }) => new Promise((done, stop) => {"
                   " signal.addEventListener('abort', () => stop(new DOMException('', 'AbortError')));"
                   " setTimeout(() => coordinator(path).then((r) => r.json()).then((study) => done([200, study])), 3000); })]);"
                   " setInterval(() => happen(farm), 500); location.hash = '#/study/2'")
        page.wait("document.querySelector('h1').textContent === 'large'", 15)


def a_farm_that_says_nothing_is_asked(browser, farm):
    with OwnAnswers(browser, farm, "/") as page:
        tag = "[...document.querySelectorAll('.studies tr')].find((r) => r.innerText.includes('large')).querySelector('.tag').innerText"
        page.wait(f"{tag} === 'running'")
        farm.client("pause", "large")
        page.wait(f"{tag} === 'paused'", 40)
        farm.client("resume", "large")


def what_is_gone_is_not_shown(browser, farm):
    with OwnAnswers(browser, farm, "/study/2") as page:
        page.wait("document.querySelector('h1').textContent === 'large'")
        page.value("answers.push([/studies\\/2$/, () => [404, { error: { message: 'study 2: no such' } }]]); happen(farm)")
        page.wait("document.querySelector('[role=alert]')?.innerText.includes('study 2: no such')", 10)


def a_refused_action_says_so_in_its_dialog(browser, farm):
    with OwnAnswers(browser, farm, "/study/2") as page:
        page.value("answers.push([/comment$/, () => [409, { error: { message: 'not today' } }]])")
        page.click("button[data-action=comment]")
        page.wait("document.activeElement.id === 'reason'")
        page.key("a", "KeyA", "a")
        page.click("button[data-confirm=comment]")
        page.wait("document.querySelector('dialog [role=alert]')?.innerText === 'not today'", 10)


def the_wall_has_no_gap(browser, farm):
    """Pairs that are published meanwhile push none out, and an error is no empty wall."""
    with OwnAnswers(browser, farm, "/") as page:
        page.value("window.newest = 500; const pairsOf = (first, n) => Array.from({ length: n }, (_, i) => ({ id: first - i, variant: 'narrow',"
                   " scene: 0, rig: 0 })); answers.push([/pairs\\?.*variant=/, () => [503, { error: { message: 'too busy' } }]],"
                   " [/pairs\\?.*before=/, (path) => [200, { pairs: pairsOf(Number(path.match(/before=(\\d+)/)[1]) - 1, 56) }]],"
                   " [/pairs\\?/, () => [200, { pairs: pairsOf(newest, 28) }]]); location.hash = '#/study/2'")
        page.wait("document.querySelectorAll('.thumb').length === 28 && document.querySelector('.thumb').hash === '#/pair/500'")
        page.click("button.more")
        page.wait("document.querySelectorAll('.thumb').length === 84")
        page.value("newest = 600; happen(farm)")
        page.value("new Promise((done) => setTimeout(done, 1000))")
        ids = page.value("[...document.querySelectorAll('.thumb')].map((a) => Number(a.hash.split('/').pop()))")
        assert ids == list(range(ids[0], ids[-1] - 1, -1)), f"pairs are missing: {ids}"
        page.click("button.more:last-of-type")
        page.wait("document.querySelector('.thumb').hash === '#/pair/600'")
        page.value("[...document.querySelectorAll('#wall, .chip')].find((e) => e.textContent === 'wide').focus()")
        page.key("Enter")
        page.wait("document.body.innerText.includes('too busy')", 10)
        assert "No pair is finished yet" not in page.text()
        assert page.value("document.activeElement.textContent") == "wide", "the keyboard lost its place"


def older_studies_stay_in_the_list(browser, farm):
    with OwnAnswers(browser, farm, "/") as page:
        page.value("const rows = (first, n) => Array.from({ length: n }, (_, i) => ({ ...farm.studies[0], study_id: first - i }));"
                   " answers.push([/studies\\?before=/, (path) => [200, { studies: rows(Number(path.split('=')[1]) - 1, 50) }]]);"
                   " happen({ ...farm, studies: rows(160, 50) })")
        page.wait("document.querySelector('.actions').innerText.includes('in the newest 50 studies')", 10)
        page.click("button.more")
        page.wait("document.querySelectorAll('.studies tbody tr').length === 100")
        page.value("happen({ ...farm, studies: rows(165, 50) })")
        page.wait("document.querySelector('.studies tbody a').hash === '#/study/165'")
        ids = page.value("[...document.querySelectorAll('.studies tbody a')].map((a) => Number(a.hash.split('/').pop()))")
        assert ids == list(range(165, 60, -1)), f"studies are missing: {ids}"


def the_chosen_log_stays(browser, farm, job):
    """The newest attempt comes first, so a new one pushes the others along."""
    with OwnAnswers(browser, farm, "/") as page:
        page.value("window.fences = ['3', '2', '1']; answers.push([/jobs\\/\\d+\\/log$/, () => [200, { attempts: fences.map((fence) => ({ fence,"
                   f" worker: 'w' + fence, unix_s: 1, error: '', log: 'log ' + fence }})) }}]]); location.hash = '{job}'")
        page.click(".chips button:nth-of-type(2)")
        page.wait("document.querySelector('.log').innerText === 'log 2'")
        page.value("fences = ['4', '3', '2', '1']; happen(farm)")
        page.wait("document.querySelectorAll('.chips button').length === 4")
        assert page.value("document.querySelector('.log').innerText") == "log 2"


def numbers_without_bounds_are_drawn(browser, farm):
    with OwnAnswers(browser, farm, "/") as page:
        # As many as 20 trainings of 100,000 steps have.
        drawn = page.value("Promise.all([import('/vendor/preact-htm.js'), import('/js/charts.js')]).then(([{ html, render }, { LineChart }]) => {"
                           " const points = Array.from({ length: 200000 }, (_, i) => ({ x: i, y: i / 2 })); const box = document.createElement('div');"
                           " render(html`<${LineChart} lines=${[{ name: 'loss', points }]} xLabel='step' yLabel='loss' />`, box);"
                           " return box.querySelector('path').getAttribute('d').length; })")
        assert drawn > 200000, drawn
        for unknown in ("null", "NaN", "-1"):
            assert page.value(f"import('/js/common.js').then((m) => m.about({unknown}))") == "not known yet", unknown


def check_answers(browser, farm, job):
    """`job` is the place of a job that has failed more than once."""
    a_slow_answer_arrives(browser, farm)
    a_farm_that_says_nothing_is_asked(browser, farm)
    what_is_gone_is_not_shown(browser, farm)
    a_refused_action_says_so_in_its_dialog(browser, farm)
    the_wall_has_no_gap(browser, farm)
    older_studies_stay_in_the_list(browser, farm)
    the_chosen_log_stays(browser, farm, job)
    numbers_without_bounds_are_drawn(browser, farm)


def sessions_change_under_the_page(browser, farm):
    """Another window signs in anew, and a link is opened in a window that shows the page."""
    first = browser.open(farm.client("page", "--http", farm.http))
    first.wait("document.body.innerText.includes('olga')")
    second = browser.open(farm.client("page", "--http", farm.http))
    second.wait("document.body.innerText.includes('olga')")
    second.close()
    first.value("location.hash = '#/study/2'")
    first.click("button[data-action=pause]")
    first.click("button[data-confirm=pause]")
    first.wait("document.querySelector('.headline .tag').textContent === 'paused'", 20)
    first.click(".who button")
    first.wait("!!document.querySelector('.signin')")
    link = farm.client("page", "--http", farm.http)
    first.value(f"location.hash = '{link[link.index('#'):]}'")
    first.wait("!document.querySelector('.signin') && document.body.innerText.includes('olga')", 20)
    assert "code" not in first.value("location.href"), "the code stays in the address"
    first.close()
