"""Say in one line what this is, and offer where to begin."""

import streamlit as st

from pages.shared import reader

say = reader.say()
st.title("atleak")
st.markdown(say("start.what"))
