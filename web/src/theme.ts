// Colours of the scene and the plots; those of the page's texts are in watch.css, under the same names.

export interface Theme {
  dark: boolean;
  sky: string;
  ground: string;
  edge: string;
  mark: string;
  middle: string;
  left: string;
  right: string;
  force: string;
  ink: string;
  muted: string;
  line: string;
}

/** Returns the colours that hold where an element stands. */
export function themeOf(element: Element): Theme {
  const style = getComputedStyle(element);
  const colour = (name: string) => style.getPropertyValue(`--${name}`).trim();
  return {
    dark: colour("scheme") === "dark",
    sky: colour("sky"),
    ground: colour("ground"),
    edge: colour("edge"),
    mark: colour("mark"),
    middle: colour("middle"),
    left: colour("left"),
    right: colour("right"),
    force: colour("force"),
    ink: colour("ink"),
    muted: colour("muted"),
    line: colour("line"),
  };
}
