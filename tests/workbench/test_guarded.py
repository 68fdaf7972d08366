"""Who may ask the workbench, and for what."""

import os
import re
from multiprocessing import active_children

import pytest


@pytest.fixture
def runs(ask):
    """Asks for the list of runs with some headers."""
    return lambda **headers: ask("/api/runs", **headers)[0]


def test_without_the_token_nothing_is_shown(ask, bench):
    """No page, no list and no script is given to who has not the token, or has a wrong one."""
    for path in ("/", "/api/runs", "/api/events", "/page/main.js", "/plotly.js", "/?token=wrong"):
        assert ask(path, token=None)[0] == 403
        assert ask(path, token="wrong")[0] == 403
    assert ask("/api/runs")[0] == 200


def test_the_token_in_the_address_becomes_a_cookie(ask, bench):
    """The printed address leads to the page with a cookie that scripts can't read, and the token leaves the address."""
    status, _ = ask(f"/?token={bench.desk.token}", token=None)
    cookie = ask.headers["set-cookie"]
    assert (status, ask.headers["location"]) == (303, "/")
    assert "HttpOnly" in cookie
    assert ask("/", token=None, cookie=cookie.partition(";")[0])[0] == 200


@pytest.mark.parametrize("other", ['prefs={"theme":"dark"}', "a=b c", "bare", "a@b=1", "x=[1,2]", 'q="'])
def test_the_cookies_of_other_programs_are_passed_over(runs, bench, other):
    """Cookies know no ports: what another program on this computer has set, of whatever form, locks nobody out."""
    own = f"labrig-{bench.port}={bench.desk.token}"
    assert runs(token=None, cookie=f"{other}; {own}") == 200
    assert runs(token=None, cookie=f"{own}; {other}") == 200
    assert runs(token=None, cookie=other) == 403


def test_a_cookie_alone_changes_nothing(ask, bench, make_run):
    """Another site's form, which carries the cookie but no header, can't change anything."""
    run = make_run(captures=10)
    cookie = f"labrig-{bench.port}={bench.desk.token}"
    assert ask("/api/tag", {"run": run, "tags": ["x"]}, token=None, cookie=cookie)[0] == 403
    assert ask("/api/tag", {"run": run, "tags": ["x"]}) == (200, {"run": run, "tags": ["x"]})


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8765", "127.0.0.1.evil.example", ""])
def test_another_hosts_name_is_refused(runs, host):
    """A foreign name that resolves to this computer (DNS rebinding) gets nothing, even with the token."""
    assert runs(host=host) == 403


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "[::1]", "LOCALHOST"])
def test_this_computers_names_are_accepted(runs, host, bench):
    """The workbench answers by each name of this computer."""
    assert runs(host=f"{host}:{bench.port}") == 200


@pytest.mark.parametrize("origin", ["http://evil.example", "https://127.0.0.1", "null", "http://127.0.0.1:1"])
def test_another_origin_is_refused(runs, origin):
    """A request of another site is refused, whatever else it carries."""
    assert runs(origin=origin) == 403


def test_another_site_is_told_by_what_the_browser_says(runs):
    """A request that the browser marks as another site's is refused where it has no Origin, too."""
    assert runs(sec_fetch_site="cross-site") == 403
    assert runs(sec_fetch_site="same-origin") == 200


def test_the_page_may_load_nothing_from_elsewhere(ask):
    """Every answer, a refusal too, tells the browser to load nothing from elsewhere and to be framed by nobody."""
    for token in ("right", None):
        ask("/", token=token)
        policy = ask.headers["content-security-policy"]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert re.findall(r"https?://([^:;\s]*)", policy) in ([], ["localhost", "127.0.0.1"])


@pytest.mark.parametrize("name", ["..", "../other", "/etc", "a/../../other", "..\\other", "run/../.."])
def test_a_path_outside_the_folder_is_refused(ask, bench, name):
    """No request reaches a run, a model or a new file outside the workbench's folder."""
    other = bench.desk.folder.parent / "other"
    other.mkdir()
    (other / "model.yaml").write_text("base: {kind: static, degree: 1}\n")
    status, said = ask(f"/api/run?run={name.replace(chr(92), '%5C')}")
    assert (status, "outside" in said["error"]) == (400, True)
    status, said = ask("/api/model", {"base": "straight", "name": f"{name}/new.yaml"})
    assert status == 400
    assert not (other / "new.yaml").exists()


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
def test_a_link_out_of_the_folder_is_refused(ask, bench):
    """A symbolic link in the folder leads nowhere outside it."""
    (bench.desk.folder / "out").symlink_to(bench.desk.folder.parent)
    status, said = ask("/api/run?run=out")
    assert (status, "outside" in said["error"]) == (400, True)


def test_the_workbench_listens_on_this_computer_only(bench):
    """Unless told otherwise, nobody else can reach it."""
    assert bench.host == "127.0.0.1"


def test_what_goes_wrong_is_said_in_one_line(ask):
    """An error of labrig reaches the page as one line, and what is no JSON object is refused."""
    assert ask("/api/run?run=nothing")[1]["error"].startswith("there is no nothing in ")
    assert ask("/api/tag", [1])[0] == 400


def test_what_computes_starts_with_the_page(ask):
    """A workbench that only watches a rig takes no process for diagnoses; the first page that opens does, and once."""
    before = set(active_children())
    assert ask("/api/runs")[0] == 200
    assert set(active_children()) == before
    assert ask("/")[0] == 200
    assert ask("/")[0] == 200
    assert len(set(active_children()) - before) == 1
