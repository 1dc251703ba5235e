/** The mechanism in three dimensions: its start position, or its motion. */

import { useEffect, useMemo, useRef, useState, type ReactElement, type RefObject } from "react";
import { Player } from "../../player/player";
import { defaultsFor } from "../../player/settings";
import { castOf, decodeMotion, decodeScene, LiveSource, sourceOf, type Scene, type SceneElement } from "../../viewer";
import { entriesOf, entryNamed, GROUND, type EntryId } from "../model/entries";
import { select, useStore } from "../store";
import { count } from "../shell/counts";
import { resolvedTheme } from "../shell/theme";
import type { Model } from "../types";
import { watchDrags, type Thread } from "./dragging";
import { keepPicture, pictureNow, type Shown } from "./shown";
import "../../player/style.css";

/** Return the entry that a part of the picture belongs to. */
export function entryOfElement(data: Model, { kind, name, body }: SceneElement): EntryId | null {
  if (name === GROUND) return GROUND;
  const sections = kind === "body" ? ["body"] : kind === "joint" ? ["joint"] : undefined;
  const exact = entryNamed(data, name, sections) ?? entryNamed(data, name);
  if (exact !== null) return exact.id;
  return body === 0 ? GROUND : null;
}

/** Return what of the state the picture shows. */
function usePicture(): { scene: unknown; motion: unknown; title: string; moves: boolean } | null {
  const check = useStore((state) => state.check?.picture ?? null);
  const simulated = useStore((state) => state.simulated);
  const motion = useStore((state) => state.showsMotion);
  const analysisPicture = useStore((state) => state.analysisPicture);
  if (analysisPicture !== null) return { ...analysisPicture, moves: true };
  if (motion && simulated !== null) return { scene: simulated.scene, motion: simulated.motion, title: "", moves: true };
  return check === null ? null : { ...check, title: "", moves: false };
}

/** Make the player of a picture in an element, with the camera of the one before. */
function makePlayer(root: HTMLElement, scene: unknown, motion: unknown, moves: boolean, before: Shown | null): Shown {
  const decoded = decodeScene(scene);
  const base = sourceOf(decoded, motion === null ? null : decodeMotion(motion, decoded.bodies.length));
  const source = new LiveSource(base, decoded.bodies.length);
  const theme = resolvedTheme(useStore.getState().theme);
  const kept = before?.player.settings.values ?? defaultsFor(decoded.bodies.length - 1);
  const settings = { ...kept, theme, curves: false, autoplay: moves };
  const player = new Player(root, { scene: decoded, source, title: "", settings }, {
    onSelect: (element) => { chosenInPicture(element); },
    onTime: (time) => { pictureNow.curves?.showTime(time); },
  });
  const size = sizeText(decoded);
  const mechanism = mechanismText();
  const same = before !== null && castOf(before.player.data.scene) === castOf(decoded);
  if (same && before.player.viewer !== null && player.viewer !== null && (before.size === size || before.mechanism === mechanism)) {
    player.viewer.rig.take(before.player.viewer.rig);
  }
  return { player, source, size, mechanism, scene: JSON.stringify(scene), base };
}

function mechanismText(): string {
  const { document, checked } = useStore.getState();
  return JSON.stringify([document?.id, checked], (key, value: unknown) => (key === "initial" || key === "layout" ? undefined : value));
}

function sizeText({ size, up, normal }: Scene): string {
  return JSON.stringify([size, up, normal]);
}

let telling = false;

function chosenInPicture(element: SceneElement | null): void {
  if (telling) return;
  const { data } = useStore.getState();
  if (element === null) return;
  const id = entryOfElement(data, element);
  if (id !== null) select([id], `${element.name} selected`);
}

export function Picture(): ReactElement {
  const host = useRef<HTMLDivElement>(null);
  const picture = usePicture();
  const [drawn, setDrawn] = useState(false);
  const scene = picture?.scene ?? null;
  const motion = picture?.motion ?? null;
  const moves = picture?.moves ?? false;
  useEffect(() => {
    const root = host.current;
    if (root === null || scene === null) return;
    showPicture(root, scene, motion, moves);
    setDrawn(true);
  }, [scene, motion, moves]);
  useEffect(() => () => {
    pictureNow.shown?.player.dispose();
    keepPicture(null);
  }, []);
  const [svg, thread] = useThread();
  useEffect(() => (host.current === null ? undefined : watchDrags(host.current, thread)), [thread]);
  useSelectionInPicture();
  return (
    <section className="picture" aria-label="3-D picture" data-testid="picture">
      <div ref={host} className="picture-host" />
      {picture === null && (drawn ? <p className="picture-old" role="status" data-testid="picture-old">Picture of the last valid model</p> : <Empty />)}
      <svg ref={svg} className="drag-thread" aria-hidden="true" data-testid="thread"><line /><circle r="5" /></svg>
      <PictureBar moves={moves} />
      <PictureNote />
    </section>
  );
}

/** Return the line from the point of a body that is dragged to the pointer. */
function useThread(): [RefObject<SVGSVGElement | null>, Thread] {
  const svg = useRef<SVGSVGElement>(null);
  const thread = useMemo<Thread>(() => ({
    show: (from, to) => {
      const area = svg.current?.getBoundingClientRect();
      if (svg.current === null || area === undefined) return;
      const [x1, y1, x2, y2] = [from[0] - area.left, from[1] - area.top, to[0] - area.left, to[1] - area.top].map(String);
      for (const [name, value] of Object.entries({ x1, y1, x2, y2 })) svg.current.querySelector("line")?.setAttribute(name, value!);
      for (const [name, value] of Object.entries({ cx: x1, cy: y1 })) svg.current.querySelector("circle")?.setAttribute(name, value!);
      svg.current.classList.add("shown");
    },
    hide: () => { svg.current?.classList.remove("shown"); },
  }), []);
  return [svg, thread];
}

function PictureNote(): ReactElement | null {
  const note = useStore((state) => state.pictureNote);
  const wrong = useStore((state) => state.posed !== null && state.posed.problem !== "");
  return <p className={`picture-note${note === "" ? " hidden" : ""}${wrong ? " wrong" : ""}`} role="status" data-testid="picture-note">{note}</p>;
}

function Empty(): ReactElement {
  const bodies = useStore((state) => entriesOf(state.data).some((each) => each.section === "body"));
  const problems = useStore((state) => state.check !== null);
  return <p className="soft picture-empty">{bodies && !problems ? "Assembling…" : bodies ? "The mechanism cannot be drawn yet: see Problems." : "The mechanism appears here as soon as it has a body."}</p>;
}

/** Show a picture; where only the places of bodies differ, they alone change. */
function showPicture(root: HTMLElement, scene: unknown, motion: unknown, moves: boolean): void {
  const before = pictureNow.shown;
  const text = JSON.stringify(scene);
  if (before !== null && !moves && before.scene === text && before.player.clock.duration === 0) {
    const bodies = before.player.data.scene.bodies.length;
    const { positions, quaternions } = decodeMotion(motion, bodies);
    before.source.show({ positions: [...positions], quaternions: [...quaternions] });
    before.player.refresh();
    return;
  }
  keepPicture((moves ? null : resized(before, scene, motion, text)) ?? anew(root, scene, motion, moves, before));
  const [id] = useStore.getState().selection;
  if (id !== undefined) markSelection([id]);
  markSources();
}

/** Return the player of before with the scene in it, where it shows the same mechanism in other sizes; else null. */
function resized(before: Shown | null, scene: unknown, motion: unknown, text: string): Shown | null {
  if (before === null || motion === null) return null;
  const decoded = decodeScene(scene);
  const base = sourceOf(decoded, decodeMotion(motion, decoded.bodies.length));
  const source = new LiveSource(base, decoded.bodies.length);
  if (!before.player.replaceScene(decoded, source)) return null;
  return { ...before, source, base, size: sizeText(decoded), mechanism: mechanismText(), scene: text };
}

function anew(root: HTMLElement, scene: unknown, motion: unknown, moves: boolean, before: Shown | null): Shown {
  before?.player.dispose();
  count("player");
  return makePlayer(root, scene, motion, moves, before);
}

function markSelection(ids: readonly EntryId[]): void {
  const { data } = useStore.getState();
  const [id] = ids;
  telling = true;
  pictureNow.shown?.player.select(id === undefined ? null : nameOf(data, id) || null);
  telling = false;
}

/** Return the name of an entry; "" where there is none any more. */
function nameOf(data: Model, id: EntryId): string {
  if (id === GROUND) return GROUND;
  const [section = "", place] = id.split("/");
  const entries = data[section];
  return Array.isArray(entries) ? ((entries[Number(place)] as { name?: string } | undefined)?.name ?? "") : "";
}

function useSelectionInPicture(): void {
  const selection = useStore((state) => state.selection);
  const highlighted = useStore((state) => state.highlighted);
  const glowing = useStore((state) => state.glowing);
  useEffect(() => { markSelection(selection); }, [selection]);
  useEffect(() => { markSources(); }, [highlighted, glowing]);
}

/** Light up what a term comes from: strongly where it was clicked, lightly where it is pointed at. */
function markSources(): void {
  const { data, highlighted, glowing } = useStore.getState();
  const lights = new Map<string, number>();
  for (const [ids, strength] of [[glowing, 0.5], [highlighted, 0.9]] as const) {
    for (const id of ids) lights.set(nameOf(data, id), strength);
  }
  pictureNow.shown?.player.viewer?.light(lights);
}

function PictureBar({ moves }: { readonly moves: boolean }): ReactElement | null {
  const simulated = useStore((state) => state.simulated);
  const stale = useStore((state) => state.simulated !== null && state.simulated.of !== state.data);
  const analysis = useStore((state) => state.analysisPicture);
  if (simulated === null && analysis === null) return null;
  const show = (motion: boolean): void => { useStore.setState({ showsMotion: motion, analysisPicture: null }); };
  return (
    <div className="picture-bar segments" role="radiogroup" aria-label="Display options">
      <button type="button" role="radio" aria-checked={!moves} onClick={() => { show(false); }}>Start position</button>
      {simulated !== null && <button type="button" role="radio" aria-checked={moves && analysis === null} onClick={() => { show(true); }}>Motion{stale ? " (before the edits)" : ""}</button>}
      {analysis !== null && <button type="button" role="radio" aria-checked>{analysis.title}</button>}
    </div>
  );
}
