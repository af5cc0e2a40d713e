"""What programs compute: operators, variables, functions, threads and time."""

from __future__ import annotations

import math
import socket

import pytest
from urscript_rig import TimeBox, run_in_time

EXPRESSIONS = {
    "1 + 2 * 3 - 4": "3",
    "(1 + 2) * 3": "9",
    "7 / 2": "3.5",
    "4 / 2": "2",
    "7 % 3": "1",
    "-7 % 3": "-1",  # as in C
    "7.5 % 2": "1.5",
    "2 * 3.0": "6",
    "-2 - -3": "1",
    "1 - 2 - 3": "-4",
    "8 / 4 / 2": "1",
    "0.1 + 0.2": "0.3",
    "1e-3": "0.001",
    ".5": "0.5",
    "1 < 2 and 2 <= 2 and 3 != 4": "True",
    "True or False and False": "True",
    "True xor True": "False",
    "True or True xor True": "True",
    "not 1 > 2": "True",
    "not True == False": "True",
    '"a" + "b" == "ab"': "True",
    '"Hello" != "World"': "True",
    "[1, 2] == [1, 2.0]": "True",
    "p[0, 0, 0, 0, 0, 0] == p[0, 0, 0, 0, 0, 1]": "False",
    "[1, 2, 3][1]": "2",
    "[[1, 2], [3, 4]][1][0]": "3",
    "[[1, 2], [3, 4]][1, 0]": "3",
    "p[1, 2, 3, 4, 5, 6][5]": "6",
    "[1, 2] + [3, 4]": "[4, 6]",
    "[2, 4] * 0.5": "[1, 2]",
    "1 - [1, 2]": "[0, -1]",
    "[[1, 2], [3, 4], [5, 6]] * [[10, 20, 30], [40, 50, 60]]": (
        "[[90, 120, 150], [190, 260, 330], [290, 400, 510]]"
    ),
    "[[1, 2], [3, 4], [5, 6]] * [10, 20]": "[50, 110, 170]",
    "-[1, 2]": "[-1, -2]",
    'str_cat("Integer ", 1)': "Integer 1",
    'str_cat("", p[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])': "p[1, 2, 3, 4, 5, 6]",
    "str_cat([True, False, True], [1, 0, 1])": "[True, False, True][1, 0, 1]",
    'str_at("Hello", 1)': "e",
    'str_find("Hello World!", "o", 5)': "7",
    'str_find("abc", "z")': "-1",
    'str_sub("0123456789abcdefghij", 5, 3)': "567",
    'str_sub("0123456789abcdefghij", 10)': "abcdefghij",
    'str_sub("abcde", 2, 50)': "cde",
    'str_sub("abc", 1, 0)': "",
    'str_len("Grüße")': "7",  # bytes
    'str_empty("")': "True",
    'to_num("12") + to_num("-1.5e1")': "-3",
    "to_str(1.5)": "1.5",
    "floor(-1.5)": "-2",
    "ceil(1.43)": "2",
    "atan2(0.5, 0.5)": f"{math.pi / 4:.6f}",
    "log(10, 100)": "2",
    "pow(5., 3)": "125",
    "sqrt(9)": "3",
    "d2r(180)": f"{math.pi:.6f}",
    "norm(-8)": "8",
    "norm([3, 4])": "5",
    "norm(p[-.2, .2, -.2, -1.57, 0, 3.14])": "3.527676",
    "normalize([0, 5, 0])": "[0, 1, 0]",
    'length("here")': "4",
    "size([[1, 2], [3, 4], [5, 6]])": "[3, 2]",
    "get_list_length([1, 3, 3, 6, 2])": "5",
    "make_list(3, 0)": "[0, 0, 0]",
    "make_list(6 / 2, 0)": "[0, 0, 0]",
    "binary_list_to_integer([True, False, False, True])": "9",
    "binary_list_to_integer(integer_to_binary_list(-57))": "-57",
    "inv([[0, 1, 0], [0, 0, 1], [1, 0, 0]])": "[[0, 0, 1], [1, 0, 0], [0, 1, 0]]",
    "inv(p[.2, .5, .1, 1.57, 0, 3.14])": (
        "p[0.193238, 0.417943, -0.296619, 1.239926, 0, 2.479852]"
    ),
    "transpose([[1, 2], [3, 4]])": "[[1, 3], [2, 4]]",
    "pose_trans(p[.2,.5,.1,1.57,0,0], p[.2,.5,.6,1.57,0,0])": (
        "p[0.4, -0.099602, 0.600478, 3.14, 0, 0]"
    ),
    "pose_add(p[.2,.5,.1,1.57,0,0], p[.2,.5,.6,1.57,0,0])": (
        "p[0.4, 1, 0.7, 3.14, 0, 0]"
    ),
    "pose_sub(p[.2,.5,.1,1.57,0,0], p[.2,.5,.6,1.57,0,0])": "p[0, 0, -0.5, 0, 0, 0]",
    "point_dist(p[.2,.5,.1,1.57,0,3.14], p[.2,.5,.6,0,1.57,3.14])": "0.5",
    "interpolate_pose(p[.2,.2,.4,0,0,0], p[.2,.2,.6,0,0,1], .5)": (
        "p[0.2, 0.2, 0.5, 0, 0, 0.5]"
    ),
    "rotvec2rpy([3.14, 1.57, 0])": "[-2.808556, -0.162024, 0.900005]",
    "rpy2rotvec([3.14, 1.57, 0])": "[2.221528, 0.001768, -2.21976]",
    "wrench_trans(p[0, 0, 0.1, 0, 0, 0], [1, 0, 0, 0, 0, 0])": (
        "[1, 0, 0, 0, -0.1, 0]"
    ),
}


def test_expressions_have_the_values_of_the_manual() -> None:
    text = "".join(f"textmsg({expression})\n" for expression in EXPRESSIONS)
    run = run_in_time(text)
    assert run.error is None
    found = dict(zip(EXPRESSIONS, run.texts, strict=True))
    assert found == EXPRESSIONS


FAILURES = {
    "x = [1, 2][k]": "1:1: index 2 of a list of 2 elements",
    "x = make_list(k + 0.5, 0)": "an integer is needed, not a float",
    "x = make_list(k * 1e18, 0)": "an integer is needed, not a float",
    "x = 1 / (k - 2)": "division by zero",
    "x = 1e308 * 10 * k % 2": "remainder of inf",
    "x = sin(1e308 * 10 * k)": "a finite number is needed, not inf",
    "x = k + one": "'+' does not apply to an integer and a string",
    "x = to_num(one)": "to_num: 'one' is not a number",
    "x = sqrt(-k)": "sqrt: -2 is negative",
    "x = acos(k)": "outside of [-1, 1]",
    "x = log(1.0, k)": "no logarithm",
    "x = pow(-k, 0.5)": "to the power of",
    "x = inv([[k, k], [k, k]])": "singular",
    "x = str_at(one, 3)": "index 3 of a string of 3 bytes",
    "x = p[k, 0, 0, 0, 0, one]": "a pose has 6 numbers, not a string",
    "x = normalize([k - 2, 0])": "a list of zeros",
    "x = k and True": "'and' applies to booleans, not to an integer",
    "x = forever(k)": "forever: calls are nested deeper than 100 levels",
    "x = nothing()": "there is no value to assign",
    "x = later": "variable 'later' has no value yet",
    "join one": "'join' waits for a thread, not for a string",
    "kill one": "'kill' ends a thread, not a string",
    "sleep(-k)": "the time is -2, less than 0",
    "one[0] = k": "a string has no elements",
    "one.x = k": "a string has no member 'x'",
    "x = struct(a = k).b": "the struct has no member 'b'; it has a",
    "pair.a = one": "the member 'a' is an integer, and cannot become a string",
    "x = k.length()": "length: an integer has no methods",
    "items.append(one)": "append: a list has elements of one kind",
    "items.insert(9, k)": "insert: index 9 of a list of 2 elements",
    "all = make_list(9, struct(q = make_list(2000, 0)))": "lists have at most 10000",
    "all = [struct(q = [1]), struct(q = make_list(9999, 0)), struct(q = [1])]": (
        "lists have at most 10000"
    ),
    "assert(k == 3)": "assert: the assertion does not hold",
    "x = str_cat(long, long)": "at most 1023 bytes, not 2000",
    "x = pose_inv(p[0, 0, 0, 1e200 * k, 0, 0])": "pose_inv: 2e+200 is too large",
    "x = get_inverse_kin(p[1e7 * k, 0, 0, 0, 0, 0])": "'x' of get_inverse_kin: 2e+07",
    "x = pow(10.0, 400.0 * k)": "to the power of",
    "x = floor(1e10 * k)": "32 bits",
    "x = 2147483647 * k": "32 bits",
    "set_gravity([k, 0, 0])": "upright",
    "rq_open()": "rq_open: the arm carries no gripper",
}


@pytest.mark.parametrize("statement", FAILURES)
def test_a_program_that_fails_stops_with_its_place(statement: str) -> None:
    run = run_in_time(
        "def forever(n):\n  return forever(n + 1)\nend\ndef nothing():\n  pass\nend\n"
        'k = 2\none = "one"\nlong = "1234567890"\nwhile str_len(long) < 1000:\n'
        "  long = str_cat(long, str_sub(long, 0, 10))\nend\n"
        "pair = struct(a = 1)\nitems = [1, 2]\n"
        f'{statement}\ntextmsg("not reached")\nlater = 1\n'
    )
    words = FAILURES[statement].removeprefix("1:1: ")
    assert run.error is not None
    assert words in str(run.error)
    assert str(run.error).startswith("p:")
    assert run.texts == []
    line = int(str(run.error).split(":")[1])
    assert line in {2, 15}


def texts(text: str) -> list[str]:
    run = run_in_time(text)
    assert run.error is None
    return run.texts


def test_variables_have_the_scopes_of_the_manual() -> None:
    assert texts("""
    def program():
      a = 0
      b = 0
      def implicit():
        a = 1
        local b = 1
        c = 3
        def inner():
          b = 2
        end
        inner()
        textmsg(b)
        global d = 4
      end
      implicit()
      textmsg(str_cat(str_cat(a, b), d))
    end
    """) == ["1", "124"]


def test_arguments_and_assignments_copy_lists() -> None:
    assert texts("""
    a = [50, 100]
    def change(list):
      list[0] = 25
      return list
    end
    b = a
    b[1] = 7
    c = change(a)
    textmsg(a)
    textmsg(b, c)
    m = [[1, 2], [3, 4]]
    m[1, 0] = 5
    m[0][1] = 6
    textmsg(m)
    q = p[1, 2, 3, 4, 5, 6]
    q[2] = 9
    textmsg(q)
    p = [1, 2]
    p[0] = 3
    textmsg(p[0] + p[1])
    """) == [
        "[50, 100]",
        "[50, 7][25, 100]",
        "[[1, 6], [5, 4]]",
        "p[1, 2, 9, 4, 5, 6]",
        "5",
    ]


def test_functions_have_defaults_named_arguments_and_recursion() -> None:
    assert texts("""
    scale = 10
    def add(a, b=scale, c=1):
      return a + b + c
    end
    def factorial(n):
      if n < 2:
        return 1
      end
      return n * factorial(n - 1)
    end
    textmsg(add(1))
    textmsg(add(1, c=2))
    textmsg(add(c=3, a=1, b=2))
    textmsg(factorial(10))
    """) == ["12", "13", "6", "3628800"]


def test_and_and_or_evaluate_no_more_than_they_need() -> None:
    assert texts("""
    def told(value, name):
      textmsg(name)
      return value
    end
    x = told(False, "a") and told(True, "b")
    y = told(True, "c") or told(True, "d")
    z = told(True, "e") xor told(True, "f")
    """) == ["a", "c", "e", "f"]


def test_loops_break_continue_and_return() -> None:
    assert texts("""
    def first_square_above(limit):
      i = 0
      while True:
        i = i + 1
        if i % 2 == 1:
          continue
        elif i * i > limit:
          return i
        else:
          pass
        end
      end
    end
    i = 0
    while i < 10:
      i = i + 1
      if i == 5:
        break
      end
    end
    textmsg(i)
    textmsg(first_square_above(50))
    if "":
      textmsg("empty")
    end
    """) == ["5", "8"]


def test_sleep_and_sync_take_simulated_time() -> None:
    run = run_in_time("sleep(1.5)\nsync()\nsync()\ntextmsg(get_steptime())\n")
    assert run.duration == pytest.approx(1.504)
    assert run.texts == ["0.002"]


def test_threads_run_beside_the_program_and_end_with_it() -> None:
    run = run_in_time("""
    count = 0
    thread counter():
      while True:
        count = count + 1
        sync()
      end
    end
    thread answer():
      sleep(0.1)
      return 42
    end
    c = run counter()
    a = run answer()
    textmsg(join a)
    kill c
    before = count
    sleep(0.1)
    textmsg(before == count)
    textmsg(count)
    """)
    assert run.error is None
    assert run.texts[:2] == ["42", "True"]
    assert int(run.texts[2]) == pytest.approx(50, abs=2)
    assert run.duration == pytest.approx(0.2, abs=0.005)


def test_a_critical_section_holds_other_threads() -> None:
    found = texts("""
    thread other():
      while True:
        textmsg("other")
        sleep(0.002)
      end
    end
    t = run other()
    sleep(0.003)
    enter_critical
    textmsg("in")
    count = 0
    while count < 20000:
      count = count + 1
    end
    textmsg("out")
    exit_critical
    sleep(0.005)
    """)
    start = found.index("in")
    assert found[start : start + 3] == ["in", "out", "other"]


def test_a_variable_may_have_the_name_of_the_outputs() -> None:
    assert texts("""
    digital_out = [1, 2, 3]
    digital_out[2] = 4
    textmsg(digital_out)
    """) == ["[1, 2, 4]"]


def test_threads_enter_a_critical_section_in_turn() -> None:
    loop = """
    thread {0}():
      while True:
        enter_critical
        textmsg("{0}")
        sync()
        exit_critical
      end
    end
    """
    run = run_in_time(
        loop.format("first")
        + loop.format("second")
        + "a = run first()\nb = run second()\nsleep(0.1)\nhalt"
    )
    assert run.error is None
    counts = [run.texts.count(name) for name in ("first", "second")]
    assert min(counts) >= 20
    assert max(counts) - min(counts) <= 1


@pytest.mark.parametrize(
    "wait", ["socket_read_binary_integer(1, timeout=0.1)", "sleep(0.1)"]
)
def test_a_thread_that_waits_in_a_critical_section_holds_nobody(wait: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        run = run_in_time(f"""
        thread other():
          while True:
            textmsg("other")
            sync()
          end
        end
        socket_open("127.0.0.1", {port})
        enter_critical
        t = run other()
        {wait}
        textmsg("read")
        count = 0
        while count < 20000:
          count = count + 1
        end
        textmsg("out")
        exit_critical
        """)
    assert run.error is None
    assert "other" in run.texts[: run.texts.index("read")]
    assert run.texts[run.texts.index("read") :][:2] == ["read", "out"]


def test_opening_a_socket_takes_a_control_period() -> None:
    box = TimeBox()
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        run = run_in_time(
            f"""
            textmsg(socket_open("127.0.0.1", {port}, "first"))
            textmsg(socket_open("127.0.0.1", {port}, "second"))
            """,
            box,
        )
    assert run.texts == ["True", "True"]
    assert run.duration == pytest.approx(2.0 / box.rate)


def test_structs_are_values_with_named_members() -> None:
    assert texts("""
    def changed(x):
      x.count = 9
      return x
    end
    s = struct(count = 1, name = "two", q = [1, 2], inner = struct(e = 1.5))
    s.count = 5
    s.q[1] = 7
    s.inner.e = 2
    other = changed(s)
    textmsg(s)
    textmsg(other.count, s[1])
    items = make_list(2, struct(k = 1))
    items[0].k = 3
    textmsg(items[0].k - .5, items)
    """) == [
        "struct(count = 5, name = two, q = [1, 7], inner = struct(e = 2))",
        "9two",
        "2.5[struct(k = 3), struct(k = 1)]",
    ]


def test_methods_of_lists() -> None:
    assert texts("""
    items = [1, 2, 3]
    items.append(4)
    items.insert(0, 0)
    textmsg(items.pop(), items)
    items.remove(0)
    items.extend([8, 9])
    textmsg(items.length(), items.slice(1, 3))
    s = struct(q = [1])
    s.q.append(3)
    textmsg(s.q.to_string())
    items.clear()
    textmsg(items)
    """) == ["4[0, 1, 2, 3]", "5[2, 3]", "[1, 3]", "[]"]


def test_time_is_a_struct_and_flags_last_between_programs() -> None:
    box = TimeBox()
    assert run_in_time("set_flag(3, True)\nsleep(1.5)", box).error is None
    run = run_in_time("t = time()\ntextmsg(t)\ntextmsg(get_flag(3), get_flag(4))", box)
    assert run.texts == ["struct(sec = 1, nanosec = 500000000)", "TrueFalse"]


def test_join_and_kill_of_a_thread_that_was_not_started_do_nothing() -> None:
    assert texts("""
    worker = 0
    join worker
    kill worker
    textmsg("on")
    """) == ["on"]


def test_after_kill_another_thread_can_move_at_once() -> None:
    run = run_in_time("""
    thread other():
      while True:
        sync()
      end
    end
    t = run other()
    sleep(0.01)
    kill t
    join t
    textmsg("ended")
    """)
    assert (run.error, run.texts) == (None, ["ended"])


def test_a_statement_goes_on_after_an_operator_or_in_brackets() -> None:
    assert texts("""
    x = 1 +
      2
    if x == 3 and
        not False or
        False:
      textmsg(str_cat("x is ",
        x))
    end
    y =
      4
    textmsg(y)
    """) == ["x is 3", "4"]


def test_a_socket_to_another_machine_is_not_opened() -> None:
    run = run_in_time('textmsg(socket_open("10.0.0.1", 80))')
    assert (run.error, run.texts) == (None, ["False"])
    assert "this machine only, not to '10.0.0.1'" in run.errors[0]


def test_halt_and_errors_in_a_thread_end_the_program() -> None:
    run = run_in_time("""
    thread stopper():
      sleep(0.1)
      halt
    end
    t = run stopper()
    sleep(10)
    """)
    assert run.error is None
    assert run.duration == pytest.approx(0.1, abs=0.01)
    failing = run_in_time("""
    x = [0]
    thread bad():
      sleep(0.1)
      x[1] = 2
    end
    t = run bad()
    sleep(10)
    """)
    assert "p:5:7: index 1 of a list of 1 elements" in str(failing.error)
    assert failing.duration == pytest.approx(0.1, abs=0.01)


def test_a_thread_that_computes_uses_up_its_periods_and_lets_others_run() -> None:
    run = run_in_time("""
    n = 0
    thread spin():
      while True:
        n = n + 1
      end
    end
    t = run spin()
    sleep(1)
    textmsg(n)
    """)
    assert run.error is None
    assert run.duration == pytest.approx(1.0, abs=0.01)
    # At most 500 statements a period, two in each turn of the loop:
    assert 50_000 < int(run.texts[0]) < 130_000


def test_an_endless_loop_without_sync_is_stopped() -> None:
    run = run_in_time("def p():\n  while True:\n    pass\n  end\nend")
    assert "add sync() to its loop" in str(run.error)
    assert str(run.error).startswith("p:")
    assert 3.9 < run.duration < 4.1


def test_too_many_threads_are_an_error() -> None:
    run = run_in_time("""
    thread idle():
      sleep(1)
    end
    i = 0
    while i < 60:
      t = run idle()
      i = i + 1
    end
    """)
    assert "more than 50 threads run" in str(run.error)


def test_long_lists_count_as_many_statements() -> None:
    run = run_in_time(
        """
    a = make_list(5000, 1.5)
    i = 0
    while i < 20:
      a[i] = 2
      a = a + a
      i = i + 1
    end
    """
    )
    assert run.error is None
    assert run.duration > 20 * 2 * 500 / 500 * 0.002 * 0.9


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("".join(f"v{k} = 1\n" for k in range(2001)), "more than 2000 variables"),
        ("x = make_list(1001, 0)\ntextmsg(x)\n", "no text"),
        (
            "m = make_list(20, 1)\nr = [m, m, m, m, m, m, m, m, m, m, m]\nn = r * "
            "transpose(r)\n",
            "too large to be multiplied",
        ),
    ],
)
def test_memory_and_work_are_limited(text: str, words: str) -> None:
    assert words in str(run_in_time(text).error)


def test_a_paused_program_stands_still() -> None:
    box = TimeBox()

    def resume_later() -> None:
        if box.programs.is_paused and box.ticks > 1000:
            box.programs.resume()

    box.when_updated.add(resume_later)
    run = run_in_time(
        "thread clock():\n  while True:\n    sync()\n  end\nend\nt = run clock()\n"
        'textmsg("a")\npause\ntextmsg("b")\n',
        box,
    )
    assert run.error is None
    assert run.texts == ["a", "b"]


def test_registers_are_shared_with_clients() -> None:
    box = TimeBox()
    box.registers.inputs.integers[5] = 17
    box.registers.inputs.bits[70] = True
    run = run_in_time(
        "write_output_integer_register(3, read_input_integer_register(5))\n"
        "write_output_boolean_register(127, read_input_boolean_register(70))\n"
        "write_output_float_register(24, 37.68)\n"
        "textmsg(read_output_float_register(24))\n",
        box,
    )
    assert run.texts == ["37.68"]
    assert box.registers.outputs.integers[3] == 17
    assert box.registers.outputs.bits[127]


def test_popups_and_messages_have_the_text_as_people_read_it() -> None:
    run = run_in_time('popup("Grüße", title="Titel")\ntextmsg("a = ", [1, 2.50])\n')
    assert [(item.text, item.title) for item in run.messages] == [
        ("Grüße", "Titel"),
        ("a = [1, 2.5]", ""),
    ]


def test_a_blocking_popup_waits_until_it_is_closed() -> None:
    box = TimeBox()

    def close_later() -> None:
        if box.ticks == 250:
            box.messages.close_popup()

    box.when_updated.add(close_later)
    run = run_in_time('popup("wait", blocking=True)\n', box)
    assert run.duration == pytest.approx(0.5, abs=0.01)
