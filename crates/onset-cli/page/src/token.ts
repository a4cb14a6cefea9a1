// The token by which the program knows its user. It comes behind the # of the address that `onset explore` has printed, and is taken out of
// it at once, so that no link has it; the browser keeps it for the pages of this server.

const KEPT = "onset-token";
/** The header in which it is shown. */
export const SHOWN = "Onset-Token";

let own = "";

/** The token; empty where there is none. */
export const token = (): string => own;

/** Takes a token out of the address. */
function taken(): string | null {
  const parts = location.hash.replace(/^#/, "").split("&");
  const found = parts.find((part) => part.startsWith("token="));
  if (found === undefined) return null;
  const rest = parts.filter((part) => part !== found).join("&");
  history.replaceState(history.state, "", rest === "" ? location.pathname : `#${rest}`);
  return found.slice("token=".length);
}

/** The token of a run that this browser has opened before. */
function kept(): string {
  try {
    return localStorage.getItem(KEPT) ?? "";
  } catch {
    // A browser may have been told to keep nothing.
    return "";
  }
}

/** Shows the token of the address, which may be good for once, and keeps the one that is given for it; without one it is that of before. */
export async function enter(): Promise<void> {
  const shown = taken();
  if (shown === null) {
    if (own === "") own = kept();
    return;
  }
  const answer = await fetch("api/enter", { method: "POST", headers: { [SHOWN]: shown } });
  const given = (await answer.json()) as { token?: string };
  // A link with a token of another run is a link like others.
  own = given.token ?? (own === "" ? kept() : own);
  if (given.token === undefined) return;
  try {
    localStorage.setItem(KEPT, own);
  } catch {
    // It is asked for again then.
  }
}
