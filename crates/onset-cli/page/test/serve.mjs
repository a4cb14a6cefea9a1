// Program that serves the page, and a browser for the tests.

import { execFileSync, spawn } from "node:child_process";
import { createInterface } from "node:readline";
import { chromium as playwright } from "playwright-core";

/** Tested program. */
export const command = process.env.ONSET_COMMAND ?? "onset";

/** Serves the page; returns its address, and a function that ends it. */
export async function serve(...args) {
  const server = spawn(command, ["explore", "--no-browser", "--port", "0", ...args], { stdio: ["ignore", "pipe", "inherit"] });
  for await (const line of createInterface({ input: server.stdout })) {
    return { address: line.trim(), end: () => server.kill() };
  }
  throw new Error("no address was printed");
}

/** Output of the command as JSON. */
export const onset = (...args) => JSON.parse(execFileSync(command, [...args, "--json"], { encoding: "utf8", maxBuffer: 1 << 28 }));

/** Arguments of `onset state` for a question. */
export const argumentsOf = ({ set, stretch }) => ["state", "--stretch", stretch, ...set.flatMap((own) => ["--set", own])];

const ARGUMENTS = ["--no-sandbox", "--no-zygote", "--in-process-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];

/** Browser: ONSET_CHROMIUM if set, on Linux the one of the packages, elsewhere an installed Chrome; null if there is no browser. */
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
