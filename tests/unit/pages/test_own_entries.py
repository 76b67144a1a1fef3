"""The user's own catalogue in the dashboard: offered with the shipped entries, and nothing breaks with it."""

from __future__ import annotations

from streamlit.testing.v1 import AppTest

from atleak.catalogue.entries import own_folder, shipped_files
from atleak.common.files import made_folder
from tests.unit.pages.conftest import choice, go, texts


def test_an_own_valve_body_is_offered_used_and_kept_though_its_file_breaks_and_goes(app: AppTest) -> None:
    text = shipped_files("controllers")["minimal_example"].read_text(encoding="utf-8")
    folder = made_folder(own_folder("controllers"))
    path = folder / "my_box.toml"
    text = text.replace('id = "minimal_example"', 'id = "my_box"', 1)
    path.write_text(text.replace("displacement_mm3 = 18000.0", "displacement_mm3 = 18.0", 1), encoding="utf-8")
    (folder / "torn.toml").write_text("[", encoding="utf-8")
    app.run()
    offered = choice(app, "Valve body").options
    assert [name for name in offered if "own:" in name] == ["Example of a workshop's own description (own: my_box)"]
    assert "torn.toml. What is wrong: page Library" in texts(app)
    choice(app, "Valve body").select("my_box").run()
    assert not app.exception
    assert "nothing was measured" in texts(app)
    assert "18 mm³ is unusual for the displacement of one revolution" in "".join(w.value for w in app.sidebar.warning)
    go(app, "20_Library")
    assert not app.exception
    assert "torn.toml: is not valid TOML" in texts(app)

    path.write_text("[", encoding="utf-8")
    app.run()
    assert not app.exception
    assert "my_box.toml: is not valid TOML" in texts(app)
    assert "Shown is the last job that could." in texts(app)
    path.unlink()
    go(app, "4_Diagnosis")
    assert not app.exception
    assert "nothing was measured" in texts(app)
