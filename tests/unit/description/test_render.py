from tool0.description.catalogue import assemble
from tool0.description.render import table_text, tree_text

ARM_LINKS = (  # from the world to the tool, as the original has them
    "world",
    "base_link",
    "base_link_inertia",
    "shoulder_link",
    "upper_arm_link",
    "forearm_link",
    "wrist_1_link",
    "wrist_2_link",
    "wrist_3_link",
    "flange",
    "tool0",
)


def test_the_tree_has_each_link_once_and_deeper_than_its_parent() -> None:
    model = assemble().model
    depth = {}
    for line in tree_text(model).splitlines():
        words = [word for word in line.split() if word[0] not in "│├└─"]
        assert words[0] not in depth
        depth[words[0]] = line.index(words[0])
    assert set(depth) == {link.name for link in model.links}
    assert all(depth[joint.parent] < depth[joint.child] for joint in model.joints)
    chain = [depth[link] for link in ARM_LINKS]
    assert chain == sorted(chain)


def test_the_tree_marks_what_is_fixed_and_what_follows() -> None:
    text = tree_text(assemble().model)
    assert "flange  ← wrist_3-flange (fixed)" in text
    assert "(revolute, mimics -1 · finger_joint)" in text
    assert "forearm_link  ← elbow_joint (revolute)" in text


def test_the_table_has_a_row_for_each_movable_joint() -> None:
    model = assemble().model
    head, units, *rows = table_text(model).splitlines()
    assert [row.split()[0] for row in rows] == [j.name for j in model.movable_joints]
    elbow = next(row for row in rows if row.startswith("elbow_joint"))
    assert elbow.split()[1:] == [
        "revolute", "0", "0", "1", "-3.1416", "3.1416", "3.1416", "150",
        "hardware_interface/EffortJointInterface",
    ]  # fmt: skip
    column = head.index("driven by")
    assert all(len(row) > column and row[column - 1] == " " for row in rows)
    assert units.split() == ["[rad|m]", "[rad|m]", "[/s]", "[N·m|N]"]
