// The program that serves the page, and a browser for it.

import { execFileSync, spawn } from "node:child_process";
import { createInterface } from "node:readline";
import { chromium as playwright } from "playwright-core";

/** The program that is tested. */
export const command = process.env.ONSET_COMMAND ?? "onset";

/** Serves the page; its address, and how to end it. */
export async function serve(...args) {
  const server = spawn(command, ["explore", "--no-browser", "--port", "0", ...args], { stdio: ["ignore", "pipe", "inherit"] });
  for await (const line of createInterface({ input: server.stdout })) {
    return { address: line.trim(), end: () => server.kill() };
  }
  throw new Error("no address was printed");
}

/** What the command prints as JSON. */
export const onset = (...args) => JSON.parse(execFileSync(command, [...args, "--json"], { encoding: "utf8", maxBuffer: 1 << 28 }));

/** Arguments of `onset state` for a question. */
export const argumentsOf = ({ set, stretch }) => ["state", "--stretch", stretch, ...set.flatMap((own) => ["--set", own])];

const ARGUMENTS = ["--no-sandbox", "--no-zygote", "--in-process-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];

/** A browser: the one that ONSET_CHROMIUM names, on Linux that of the packages, elsewhere an installed Chrome; nothing where there is none. */
export async function browser() {
  const own = process.env.ONSET_CHROMIUM;
  try {
    if (own) return await playwright.launch({ executablePath: own, args: ARGUMENTS });
    if (process.platform === "linux" && process.arch === "x64") {
      const { default: packed } = await import("@sparticuz/chromium");
      return await playwright.launch({ executablePath: await packed.executablePath(), args: ARGUMENTS });
    }
    return await playwright.launch({ channel: "chrome", args: ARGUMENTS });
  } catch (error) {
    console.error(`== NOT TESTED: the page in a browser. None could be started: ${error}\n== name one with ONSET_CHROMIUM`);
    return null;
  }
}
