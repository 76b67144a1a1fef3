"""Serve the dashboard: ``atleak app`` starts it by ``streamlit run``."""

import threading
import webbrowser
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import streamlit as st

from pages.shared.requests_let_in import bracketed, guards


@asynccontextmanager
async def browser_opened(_: st.App) -> AsyncIterator[None]:
    """Show the dashboard in a browser, where this machine has a screen."""
    if not st.get_option("server.headless"):
        address = f"http://{bracketed(st.get_option('server.address'))}:{st.get_option('server.port')}"
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    yield


app = st.App(
    Path(__file__).with_name("app.py"),
    lifespan=browser_opened,
    middleware=guards(st.get_option("server.allowedHosts")),
)
