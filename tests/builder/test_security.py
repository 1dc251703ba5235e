"""Whoever is not the page of this run gets nothing: each rule shown against a running server."""

from __future__ import annotations

import json
import os
import socket
import time
from pathlib import Path

import pytest

from symbody.builder.run import listening_socket
from symbody.errors import EnvironmentFault
from tests.builder.conftest import Builder

SCHEMA = b"{}"


def test_it_listens_on_this_computer_only(builder: Builder) -> None:
    outside = [info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)]
    for address in {str(each) for each in outside} - {"127.0.0.1"}:
        with socket.socket() as probe:
            probe.settimeout(2.0)
            assert probe.connect_ex((address, builder.settings.port)) != 0


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "localhost.evil.example:{port}",
             "127.0.0.1:{port}.evil.example", "0.0.0.0:{port}", "[::1]:{port}", ""]
)  # fmt: skip
def test_another_name_of_the_host_is_refused(builder: Builder, host: str) -> None:
    headers = builder.headers(Host=host.format(port=builder.settings.port))
    assert builder.send("POST", "/api/schema", SCHEMA, headers).status == 403
    assert builder.send("GET", "/", headers={"Host": headers["Host"]}).status == 403


def test_both_names_of_this_computer_are_answered_and_two_at_once_are_not(builder: Builder) -> None:
    for host in ("127.0.0.1", "localhost"):
        headers = builder.headers(Host=f"{host}:{builder.settings.port}")
        assert builder.send("POST", "/api/recent", b"{}", headers).status == 200
    with socket.create_connection(("127.0.0.1", builder.settings.port)) as line:
        own = f"127.0.0.1:{builder.settings.port}"
        line.sendall(f"GET / HTTP/1.1\r\nHost: {own}\r\nHost: evil.example\r\n\r\n".encode())
        assert b" 400 " in line.recv(100).split(b"\r\n")[0] + b" "


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://127.0.0.1:{port}"]
)
def test_another_origin_is_refused(builder: Builder, origin: str) -> None:
    headers = builder.headers(Origin=origin.format(port=builder.settings.port))
    assert builder.send("POST", "/api/recent", b"{}", headers).status == 403


def test_what_the_browser_says_of_other_sites_counts(builder: Builder) -> None:
    for site, status in (("cross-site", 403), ("same-site", 403), ("same-origin", 200), ("none", 200)):
        headers = builder.headers(Sec_Fetch_Site=site)
        assert builder.send("POST", "/api/recent", b"{}", headers).status == status
    assert builder.send("GET", "/assets/page.js", headers={"Sec-Fetch-Site": "cross-site"}).status == 403


def test_the_own_origin_is_answered_without_cors(builder: Builder) -> None:
    own = f"http://127.0.0.1:{builder.settings.port}"
    answer = builder.send("POST", "/api/recent", b"{}", builder.headers(Origin=own))
    assert answer.status == 200
    assert not [name for name in answer.headers if name.startswith("access-control")]
    assert builder.send("OPTIONS", "/api/recent", headers={"Origin": own}).status == 405


@pytest.mark.parametrize("token", [None, "", "wrong", "\u00e9"])
def test_without_the_token_of_this_run_nothing_is_answered(builder: Builder, token: str | None) -> None:
    answer = builder.send("POST", "/api/recent", b"{}", builder.headers(X_Symbody_Token=token))
    assert answer.status == 401 and answer.code == "builder.refused"


@pytest.mark.parametrize(
    "kind", [None, "text/plain", "application/x-www-form-urlencoded", "multipart/form-data"]
)
def test_only_json_is_read(builder: Builder, kind: str | None) -> None:
    assert builder.send("POST", "/api/recent", b"{}", builder.headers(Content_Type=kind)).status == 415


def test_the_page_needs_the_key_and_then_a_cookie_of_this_site(builder: Builder) -> None:
    closed = builder.send("GET", "/")
    assert closed.status == 403 and builder.settings.token not in closed.content.decode()
    assert builder.send("GET", "/?key=wrong").status == 403
    opened = builder.send("GET", f"/?key={builder.settings.key}")
    cookie = opened.headers["set-cookie"]
    assert opened.status == 303 and "HttpOnly" in cookie and "samesite=strict" in cookie.lower()
    page = builder.send("GET", "/", headers={"Cookie": cookie.split(";")[0]})
    assert page.status == 200
    assert f'<meta name="symbody-token" content="{builder.settings.token}">' in page.content.decode()


def test_headers_of_every_answer(builder: Builder) -> None:
    answers = [builder.send("GET", "/"), builder.send("GET", "/assets/page.js"), builder.ask("recent"),
               builder.ask("no_such"), builder.send("POST", "/api/recent", b"{}")]  # fmt: skip
    for answer in answers:
        policy = answer.headers["content-security-policy"]
        assert "default-src 'self'" in policy and "frame-ancestors 'none'" in policy
        assert "unsafe-eval" not in policy and "script-src 'self';" in policy
        assert answer.headers["x-content-type-options"] == "nosniff"
    script = builder.send("GET", "/assets/page.js")
    assert script.headers["content-type"].startswith("text/javascript")


@pytest.mark.parametrize("path", ["/assets/../index.html", "/assets/%2e%2e/index.html", "/assets/..%5cindex.html",
                                  "/assets//etc/passwd", "/assets/", "/docs", "/openapi.json"])  # fmt: skip
def test_nothing_but_the_assets_is_served(builder: Builder, path: str) -> None:
    assert builder.send("GET", path).status in (400, 404)


OUTSIDE = ["{models}/../secret.toml", "/etc/passwd.toml", "//etc/hosts.toml", "{models}/link.toml", "{models}/way/x.toml",
           "../secret.toml", "{models}/a\0.toml", "", "{models}/CON.toml", "{models}/nul", "~root/x.toml"]  # fmt: skip


@pytest.mark.parametrize("path", OUTSIDE)
def test_no_path_leads_out_of_the_roots(builder: Builder, path: str) -> None:
    secret = builder.folder.parent / "secret.toml"
    secret.write_text('name = "secret"\n')
    for name, target in (("link.toml", secret), ("way", secret.parent)):
        if not (builder.folder / name).is_symlink():
            os.symlink(target, builder.folder / name)
    given = path.format(models=builder.folder)
    document = builder.get("new")
    answers = [builder.ask("open", path=given), builder.ask("folder", path=given or "/"),
               builder.ask("save", document=document["document"], path=given, data=document["data"])]  # fmt: skip
    assert [answer.status for answer in answers if answer.status not in (403, 422)] == []
    assert secret.read_text() == 'name = "secret"\n'
    assert all(b"secret" not in answer.content or b"secret.toml" in answer.content for answer in answers)


def test_only_model_files_are_written(builder: Builder) -> None:
    document = builder.get("new")
    for name in (".bashrc", "x.py", "x.toml.exe", "x"):
        answer = builder.ask(
            "save", document=document["document"], path=str(builder.folder / name), data=document["data"]
        )
        assert answer.status == 422 and answer.code == "builder.ending"
        assert not (builder.folder / name).exists()


def test_drafts_are_no_way_to_files(builder: Builder) -> None:
    for name in ("../../secret", "..%2f", "a" * 31, "A" * 32, "0" * 32):
        assert builder.ask("open", draft=name).status == 404
        assert builder.ask("draft", document=name, data={}).status == 404


def test_large_and_deep_and_broken_requests_are_refused(builder: Builder) -> None:
    large = json.dumps({"text": "x" * builder.settings.limits.body}).encode()
    assert builder.send("POST", "/api/formula", large, builder.headers()).status == 413
    deep = b'{"data":' + b"[" * 5000 + b"]" * 5000 + b"}"
    assert builder.send("POST", "/api/check", deep, builder.headers()).status == 400
    for broken in (b"", b"{", b"[]", b'{"text": 1}', b'{"text": "x", "more": 1}', b"\xff"):
        answer = builder.send("POST", "/api/formula", broken, builder.headers())
        assert answer.status in (400, 422) and answer.data["problems"]
    long = builder.ask("formula", text="+".join(["x"] * 6000))
    assert long.status == 422


def test_a_request_that_never_ends_is_given_up(builder: Builder) -> None:
    with socket.create_connection(("127.0.0.1", builder.settings.port)) as line:
        head = "".join(f"{name}: {value}\r\n" for name, value in builder.headers().items())
        own = f"127.0.0.1:{builder.settings.port}"
        line.sendall(
            f"POST /api/recent HTTP/1.1\r\nHost: {own}\r\n{head}Content-Length: 100\r\n\r\n{{".encode()
        )
        line.settimeout(20.0)
        begun = time.monotonic()
        assert b"408" in line.recv(200).split(b"\r\n")[0]
        assert time.monotonic() - begun < 15.0  # far from for ever
    assert builder.ask("recent").status == 200


def test_texts_of_models_stay_texts(builder: Builder) -> None:
    name = "<script>alert(1)</script>"
    body = {"name": name, "mass": "1"}
    answer = builder.ask("check", data={"name": name, "body": [body], "parameters": {"<b>": "x<1"}})
    assert answer.headers["content-type"].startswith("application/json")
    shown = builder.get("formula", text="if(x < 1, x, 2)")["mathml"]
    assert "<script" not in json.dumps(answer.data["formulas"]) and "&lt;" in shown


def test_faults_of_ours_tell_no_insides(builder: Builder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symbody.builder.app.elements", lambda: 1 / 0)
    answer = builder.ask("schema")
    assert answer.status == 500 and answer.code == "builder.fault"
    assert b"Traceback" not in answer.content and b".py" not in answer.content


def test_a_port_that_is_taken_gives_the_next_or_an_error(builder: Builder) -> None:
    with pytest.raises(EnvironmentFault) as caught:
        listening_socket(builder.settings.port)
    assert caught.value.problems[0].code == "builder.port" and "--port 0" in caught.value.problems[0].fix
    first, second = listening_socket(None), listening_socket(None)
    assert first.getsockname()[1] != second.getsockname()[1]
    first.close()
    second.close()


def test_files_of_the_state_are_the_users_alone(builder: Builder) -> None:
    document = builder.get("new")
    builder.get("draft", document=document["document"], data={"name": "secret"})
    drafts = Path(builder.settings.state, "drafts")
    assert drafts.stat().st_mode & 0o077 == 0
