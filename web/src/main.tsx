import { render } from "preact";
import { App } from "./app";
import { connection } from "./connection";
import { watchDriving } from "./driving";
import { watchModel } from "./model";
import "./styles/tokens.css";
import "./styles/base.css";
import "./styles/controls.css";
import "./styles/layout.css";
import "./styles/panels.css";

watchDriving();
watchModel();
connection.open();

const app = document.getElementById("app");
if (app) render(<App />, app);
