import { render } from "preact";
import { App } from "./app";
import { connection } from "./connection";
import { watchDriving } from "./driving";
import { watchGuiding } from "./guiding";
import { watchJog } from "./jog";
import { watchModel } from "./model";
import { watchRecording } from "./recording";
import { watchSilence } from "./silence";
import "./styles/tokens.css";
import "./styles/base.css";
import "./styles/controls.css";
import "./styles/layout.css";
import "./styles/panels.css";
import "./styles/recording.css";

watchDriving();
watchJog();
watchGuiding();
watchModel();
watchSilence();
watchRecording();
connection.open();

const app = document.getElementById("app");
if (app) render(<App />, app);
