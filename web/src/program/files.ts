/** Programs that are saved with the robot, and files. */
import { signal } from "@preact/signals";
import { connection } from "../connection";
import { t } from "../i18n";
import { report } from "../notices";
import type { ErrorInfo, ExportProgram, SavedProgram } from "../protocol";
import { save as saveFile } from "../ui/download";
import { isChanged, noteSaved, open, program, rename } from "./editor";
import { requested } from "./running";

export const savedPrograms = signal<readonly SavedProgram[]>([]);

const SUFFIXES: Record<ExportProgram["format"], string> = {
  yaml: "yaml",
  python: "py",
  urscript: "script",
};

/** Tell the user why something was refused; return whether it was not. */
function isDone(problem: ErrorInfo | null): boolean {
  if (problem) report("error", problem.message);
  return problem === null;
}

export async function refresh(): Promise<void> {
  const answer = await connection.ask("list_programs");
  if (answer.problem === null) savedPrograms.value = answer.result;
}

export async function save(): Promise<void> {
  const saving = program.peek();
  if (!isDone(await connection.request("save_program", { program: requested() }))) {
    return;
  }
  noteSaved(saving);
  report("info", t("program.saved", { name: saving.name }));
  await refresh();
}

export async function openSaved(name: string): Promise<void> {
  const answer = await connection.ask("read_program", { name });
  if (answer.problem) isDone(answer.problem);
  else open(answer.result, true);
}

/** Give the saved program another name. */
export async function renameSaved(name: string, newName: string): Promise<void> {
  const problem = await connection.request("rename_program", {
    name,
    new_name: newName,
  });
  if (!isDone(problem)) return;
  if (program.peek().name === name) {
    const wasSaved = !isChanged.peek();
    rename(newName);
    if (wasSaved) noteSaved(program.peek());
  }
  await refresh();
}

export async function deleteSaved(name: string): Promise<void> {
  isDone(await connection.request("delete_program", { name }));
  await refresh();
}

/** Edit the program of a file. */
export async function importFile(file: File): Promise<void> {
  const answer = await connection.ask("parse_program", { text: await file.text() });
  if (answer.problem) isDone(answer.problem);
  else open(answer.result, false);
}

export async function exportAs(format: ExportProgram["format"]): Promise<void> {
  const answer = await connection.ask("export_program", {
    program: requested(),
    format,
  });
  if (answer.problem) {
    isDone(answer.problem);
    return;
  }
  const name = program.peek().name.replaceAll(/[^\w.-]+/g, "_");
  saveFile(new Blob([answer.result]), `${name}.${SUFFIXES[format]}`);
}
