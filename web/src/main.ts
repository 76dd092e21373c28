import "uplot/dist/uPlot.min.css";
import "./watch.css";
import { mount } from "./app";
import { follow } from "./live";

for (const place of document.querySelectorAll<HTMLElement>(".mjxwalk-replay")) {
  mount(place).then((app) => {
    Object.assign(place, { replay: app });
    if (place.dataset["live"] !== undefined) follow(place, app);
  }).catch((error: unknown) => {
    place.dataset["state"] = "failed";
    const told = document.createElement("p");
    told.className = "sorry";
    told.textContent = `The replay cannot be shown: ${error instanceof Error ? error.message : String(error)}`;
    place.append(told);
    throw error;
  });
}
