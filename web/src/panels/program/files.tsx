/** The program's name, the saved ones, and files. */
import { useRef } from "preact/hooks";
import { t } from "../../i18n";
import {
  EMPTY,
  isChanged,
  mayRedo,
  mayUndo,
  open,
  program,
  redo,
  rename,
  undo,
} from "../../program/editor";
import {
  deleteSaved,
  exportAs,
  importFile,
  openSaved,
  renameSaved,
  save,
  savedPrograms,
} from "../../program/files";
import { Button, IconButton } from "../../ui/button";
import { Menu } from "../../ui/menu";
import { Select } from "../../ui/select";
import { confirm } from "../confirmation";
import { FileIcon, RedoIcon, UndoIcon } from "./icons";

/** Do it at once, or after a question if changes would be lost. */
function unlessChanged(act: () => void): void {
  if (isChanged.peek()) confirm(t("program.discard"), t("program.discardIt"), act);
  else act();
}

export function Files() {
  const { name } = program.value;
  const isSaved = savedPrograms.value.some((one) => one.name === name);
  const store = () => {
    if (isSaved && isChanged.peek()) {
      confirm(t("program.overwrite", { name }), t("confirm.overwrite"), () => {
        void save();
      });
    } else void save();
  };
  return (
    <section class="group" aria-labelledby="program-title">
      <header>
        <h2 id="program-title">{t("program.title")}</h2>
        <span class="header-buttons">
          <IconButton
            label={t("program.undo")}
            disabled={!mayUndo.value}
            data-testid="program-undo"
            onClick={undo}
          >
            <UndoIcon />
          </IconButton>
          <IconButton
            label={t("program.redo")}
            disabled={!mayRedo.value}
            data-testid="program-redo"
            onClick={redo}
          >
            <RedoIcon />
          </IconButton>
          <FileMenu isSaved={isSaved} />
        </span>
      </header>
      <Select
        label={t("program.open")}
        value=""
        options={[
          { value: "", label: t("program.open") },
          ...savedPrograms.value.map((one) => ({
            value: one.name,
            label: one.error === "" ? one.name : `${one.name}: ${one.error ?? ""}`,
          })),
        ]}
        data-testid="program-open"
        onChange={(chosen) => {
          if (chosen === "") return;
          unlessChanged(() => {
            void openSaved(chosen);
          });
        }}
      />
      <form
        class="row"
        onSubmit={(event) => {
          event.preventDefault();
          store();
        }}
      >
        <span class="field grow">
          <input
            type="text"
            maxLength={200}
            value={name}
            aria-label={t("program.name")}
            data-testid="program-name"
            onChange={(event) => {
              const typed = event.currentTarget.value.trim();
              if (typed === "") event.currentTarget.value = name;
              else rename(typed);
            }}
          />
        </span>
        <Button type="submit" data-testid="program-save">
          {t("program.save")}
        </Button>
      </form>
    </section>
  );
}

function FileMenu({ isSaved }: { isSaved: boolean }) {
  const file = useRef<HTMLInputElement | null>(null);
  const { name } = program.value;
  return (
    <Menu label={t("program.files")} icon={<FileIcon />} data-testid="program-files">
      <Button
        kind="ghost"
        data-testid="program-new"
        onClick={() => {
          unlessChanged(() => {
            open(EMPTY, false);
          });
        }}
      >
        {t("program.new")}
      </Button>
      <Button
        kind="ghost"
        data-testid="program-import"
        onClick={() => {
          file.current?.click();
        }}
      >
        {t("program.import")}
      </Button>
      <input
        ref={file}
        type="file"
        accept=".yaml,.yml"
        hidden
        aria-label={t("program.import")}
        data-testid="program-file"
        onChange={({ currentTarget }) => {
          const [chosen] = currentTarget.files ?? [];
          if (chosen) {
            unlessChanged(() => {
              void importFile(chosen);
            });
          }
          currentTarget.value = "";
        }}
      />
      {(["yaml", "python", "urscript"] as const).map((format) => (
        <Button
          key={format}
          kind="ghost"
          data-testid={`program-export-${format}`}
          onClick={() => void exportAs(format)}
        >
          {t(`program.export.${format}`)}
        </Button>
      ))}
      {isSaved && <Rename name={name} />}
      {isSaved && (
        <Button
          kind="ghost"
          data-testid="program-delete-saved"
          onClick={() => {
            confirm(t("program.deleteSaved", { name }), t("confirm.delete"), () => {
              void deleteSaved(name);
            });
          }}
        >
          {t("program.deleteIt")}
        </Button>
      )}
    </Menu>
  );
}

function Rename({ name }: { name: string }) {
  const field = useRef<HTMLInputElement | null>(null);
  return (
    <form
      class="row"
      onSubmit={(event) => {
        event.preventDefault();
        const typed = field.current?.value.trim() ?? "";
        if (typed !== "" && typed !== name) void renameSaved(name, typed);
      }}
    >
      <span class="field grow">
        <input
          type="text"
          maxLength={200}
          ref={field}
          defaultValue={name}
          aria-label={t("program.newName")}
          data-testid="program-new-name"
        />
      </span>
      <Button type="submit" data-testid="program-rename">
        {t("program.rename")}
      </Button>
    </form>
  );
}
