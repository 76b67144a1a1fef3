"""Serve the dashboard: ``atleak app`` starts it by ``streamlit run``."""

import asyncio
import gc
import logging
import os
import threading
import webbrowser
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib import import_module
from pathlib import Path

import streamlit as st
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import RedirectResponse, Response
from starlette.routing import Route

from atleak.common.access import ENDS_AFTER
from atleak.common.printable import printable_log
from pages.shared import places
from pages.shared.entrance import may_send_files
from pages.shared.left_sessions import end_when_left, let_go_in_time
from pages.shared.requests_let_in import bracketed, guards


def moved(request: Request) -> RedirectResponse:
    """Lead from the address of a page of before to the one that holds it now."""
    return RedirectResponse(places.moved(request.url.path.rpartition("/")[2], request.url.query))


async def customers_screen(request: Request) -> Response:
    """Answer at the address that shows a customer his job; what that needs is imported when it is first asked for."""
    await run_in_threadpool(import_module, "pages.shared.customer")  # else every session waits for it
    from pages.shared.customer import screen

    return await screen(request)


@asynccontextmanager
async def served(_: st.App) -> AsyncIterator[None]:
    """Show the dashboard in a browser, where this machine has a screen, and let sessions go that were left."""
    printable_log()
    logging.disable(logging.WARNING)  # else it says twice that no page is drawn by this
    st.navigation([Path(app.script_path)])  # else the first request for a page's address imports all of it unseen
    logging.disable(logging.NOTSET)
    gc.freeze()  # no later collection looks through Streamlit's own modules
    if not st.get_option("server.headless"):
        address = f"http://{bracketed(st.get_option('server.address'))}:{st.get_option('server.port')}"
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    tasks = [asyncio.create_task(let_go_in_time())]
    if seconds := os.environ.get(ENDS_AFTER):
        tasks.append(asyncio.create_task(end_when_left(float(seconds))))
    yield
    for task in tasks:
        task.cancel()


app = st.App(
    Path(__file__).with_name("app.py"),
    lifespan=served,
    routes=[
        *(Route(f"/{old}", moved) for old in places.MOVED),
        Route(f"{places.CUSTOMER}/{{token}}", customers_screen, methods=["GET", "POST"]),
    ],
    middleware=guards(st.get_option("server.allowedHosts"), may_send_files),
)
