// Asks the server that a page came from for newer walkers, as a run goes on.

import { App } from "./app";
import type { Show } from "./show";
import { unzip } from "./unpack";

const INTERVAL = 1500; // ms between questions

interface News {
  number: number;
  show: Show;
  series: string;
}

/** Replaces the replay whenever there is a newer one. */
export function follow(place: HTMLElement, first: App): void {
  let app = first;
  let number = Number(place.dataset["live"]);
  const ask = async () => {
    // A server that has gone leaves the last walker to be looked at.
    const answer = await fetch(`news?after=${number}`).catch(() => null);
    if (answer?.status === 200) {
      const news = (await answer.json()) as News;
      const bytes = await unzip(news.series);
      const playing = app.playing;
      app.leave();
      app = new App(place, news.show, bytes);
      if (!playing) app.pause();
      Object.assign(place, { replay: app });
      number = news.number;
    }
    if (answer) setTimeout(() => void ask(), INTERVAL);
  };
  setTimeout(() => void ask(), INTERVAL);
}
