//! A node of J1939: its NAME, the claim to an address, and answers to requests (SAE J1939-81, J1939-21).
//!
//! Uses no socket and no clock: frames and times go in, frames come out. Without an address only claims are
//! sent. A commanded address (65240) is ignored.

use std::collections::VecDeque;

/// The global address.
const GLOBAL: u8 = 0xff;
/// The null address, of nodes without one.
const NULL: u8 = 0xfe;
/// Address claimed, and request: upper byte of the parameter group.
const CLAIM: u8 = 0xee;
const REQUEST: u8 = 0xea;
const ACKNOWLEDGEMENT: u8 = 0xe8;
/// The group that a request names for the claim.
const CLAIM_GROUP: u32 = 60928;
/// Priority of these groups.
const PRIORITY: u32 = 6;
/// Time from a claim until the address may be used, without objection [ns] (J1939-81, 4.4.2.1).
const WAIT: u64 = 250_000_000;
/// "Cannot claim" is delayed by an individual time, at most 153 ms, so that two nodes do not send at once [ns].
const MOST_DELAY: u64 = 153_000_000;
/// Addresses that a node may choose itself (J1939-81, table A2).
const FREE: std::ops::RangeInclusive<u8> = 128..=247;

/// Frames that a node must receive: identifier and mask, both of 29 bits.
pub const HEARS: [(u32, u32); 2] = [
    ((CLAIM as u32) << 16, 0x00ff_0000),
    ((REQUEST as u32) << 16, 0x00ff_0000),
];

/// The fields of a NAME (J1939-81, 4.1.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Name {
    /// Number of this unit among those of its maker, 21 bits.
    pub identity: u32,
    /// Manufacturer code, 11 bits; 2047: not available.
    pub manufacturer: u32,
    /// Instance of the electronic control unit, 3 bits.
    pub ecu_instance: u32,
    /// Instance of the function, 5 bits.
    pub function_instance: u32,
    /// Function, 8 bits; 255: not available.
    pub function: u32,
    /// Vehicle system, 7 bits; 127: not available.
    pub vehicle_system: u32,
    /// Instance of the vehicle system, 4 bits.
    pub vehicle_system_instance: u32,
    /// Industry group, 3 bits; 3 is construction.
    pub industry_group: u32,
    /// Arbitrary address capable: it claims another address after it has lost one.
    pub arbitrary_address: bool,
}

impl Name {
    /// Its 64 bits; of two nodes the one with the smaller number keeps the address.
    pub const fn bits(&self) -> u64 {
        (self.identity as u64 & 0x1f_ffff)
            | (self.manufacturer as u64 & 0x7ff) << 21
            | (self.ecu_instance as u64 & 7) << 32
            | (self.function_instance as u64 & 0x1f) << 35
            | (self.function as u64 & 0xff) << 40
            | (self.vehicle_system as u64 & 0x7f) << 49
            | (self.vehicle_system_instance as u64 & 0xf) << 56
            | (self.industry_group as u64 & 7) << 60
            | (self.arbitrary_address as u64) << 63
    }
}

impl Default for Name {
    fn default() -> Self {
        Self {
            identity: 0,
            manufacturer: 2047,
            ecu_instance: 0,
            function_instance: 0,
            function: 255,
            vehicle_system: 127,
            vehicle_system_instance: 0,
            industry_group: 3,
            arbitrary_address: true,
        }
    }
}

/// State of the claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nothing was claimed yet.
    Silent,
    /// Claimed; it is the node's without objection until this time [ns].
    Waiting(u8, u64),
    /// The node has it.
    Has(u8),
    /// No address is available.
    Lost,
}

/// A frame of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Said {
    /// Identifier of 29 bits.
    pub id: u32,
    /// Content.
    pub data: [u8; 8],
    /// When it is due [ns].
    due: u64,
}

/// A node of J1939.
#[derive(Debug, Clone)]
pub struct Node {
    name: Name,
    preferred: u8,
    state: State,
    /// Addresses claimed by other nodes, with their NAMEs.
    taken: [Option<u64>; 256],
    say: VecDeque<Said>,
    /// Another node claims with the same NAME: arbitration cannot separate the two.
    has_double: bool,
    /// Groups sent by this node that were requested.
    asked: Vec<u32>,
    groups: Vec<u32>,
}

impl Node {
    /// A node that wants the address `preferred` and sends these parameter groups.
    pub fn new(name: Name, preferred: u8, groups: Vec<u32>) -> Self {
        Self {
            name,
            preferred,
            state: State::Silent,
            taken: [None; 256],
            say: VecDeque::new(),
            has_double: false,
            asked: Vec::new(),
            groups,
        }
    }

    /// Claims from the start: the addresses of other nodes are unknown.
    pub fn begin(&mut self, now: u64) {
        self.taken = [None; 256];
        self.say.clear();
        self.claim(self.preferred, now);
    }

    /// The address that may be used at this time.
    pub fn address(&mut self, now: u64) -> Option<u8> {
        match self.state {
            State::Waiting(address, until) if now >= until => {
                self.state = State::Has(address);
                Some(address)
            }
            State::Has(address) => Some(address),
            _ => None,
        }
    }

    /// Whether no address is available to it.
    pub fn has_lost(&self) -> bool {
        self.state == State::Lost
    }

    /// Whether another node has the same NAME.
    pub fn has_double(&self) -> bool {
        self.has_double
    }

    /// The next frame that is due.
    pub fn say(&mut self, now: u64) -> Option<Said> {
        self.say
            .front()
            .is_some_and(|said| said.due <= now)
            .then(|| self.say.pop_front())?
    }

    /// The groups that were requested since the last call.
    pub fn take_asked(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.asked)
    }

    /// Takes a frame of another node with an identifier of 29 bits.
    pub fn take(&mut self, id: u32, data: &[u8], now: u64) {
        let [_, format, to, from] = id.to_be_bytes();
        match (format, data) {
            (CLAIM, [..]) => {
                if let Some(name) = data.first_chunk::<8>() {
                    self.other_claims(from, u64::from_le_bytes(*name), now);
                }
            }
            (REQUEST, [low, middle, high, ..]) => {
                let group = u32::from_le_bytes([*low, *middle, *high, 0]);
                self.requested(group, to, from, now);
            }
            _ => {}
        }
    }

    fn other_claims(&mut self, address: u8, name: u64, now: u64) {
        let mine = self.name.bits();
        self.has_double |= name == mine;
        if address >= NULL || name == mine {
            return;
        }
        self.taken[usize::from(address)] = Some(name);
        let (State::Waiting(own, _) | State::Has(own)) = self.state else {
            return;
        };
        if own != address {
            return;
        }
        if mine < name {
            // Arbitration won: the other node must release the address.
            self.taken[usize::from(address)] = None;
            self.speak(CLAIM, GLOBAL, own, mine.to_le_bytes(), now);
            return;
        }
        let next = FREE.clone().find(|a| self.taken[usize::from(*a)].is_none());
        match next.filter(|_| self.name.arbitrary_address) {
            Some(next) => self.claim(next, now),
            None => {
                self.state = State::Lost;
                self.cannot_claim(now);
            }
        }
    }

    fn requested(&mut self, group: u32, to: u8, from: u8, now: u64) {
        let own = match self.state {
            State::Waiting(address, _) | State::Has(address) => Some(address),
            State::Silent | State::Lost => None,
        };
        let is_for_me = to == GLOBAL || Some(to) == own;
        match (group, own) {
            (CLAIM_GROUP, Some(own)) if is_for_me => {
                self.speak(CLAIM, GLOBAL, own, self.name.bits().to_le_bytes(), now);
            }
            (CLAIM_GROUP, None) if is_for_me && self.state == State::Lost => {
                self.cannot_claim(now);
            }
            (_, Some(own)) if is_for_me && self.address(now).is_some() => {
                if self.groups.contains(&group) {
                    if !self.asked.contains(&group) {
                        self.asked.push(group);
                    }
                } else if to == own {
                    // A negative acknowledgement, only to a request that is addressed to this node alone.
                    let [low, middle, high, _] = group.to_le_bytes();
                    let data = [1, GLOBAL, GLOBAL, GLOBAL, from, low, middle, high];
                    self.speak(ACKNOWLEDGEMENT, GLOBAL, own, data, now);
                }
            }
            _ => {}
        }
    }

    fn claim(&mut self, address: u8, now: u64) {
        self.state = State::Waiting(address, now + WAIT);
        let name = self.name.bits().to_le_bytes();
        self.speak(CLAIM, GLOBAL, address, name, now);
    }

    fn cannot_claim(&mut self, now: u64) {
        let name = self.name.bits();
        let spread = name.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        let due = now + spread % MOST_DELAY;
        self.speak(CLAIM, GLOBAL, NULL, name.to_le_bytes(), due);
    }

    fn speak(&mut self, format: u8, to: u8, from: u8, data: [u8; 8], due: u64) {
        let id = PRIORITY << 26 | u32::from_be_bytes([0, format, to, from]);
        if self.say.len() < MOST_WAITING {
            self.say.push_back(Said { id, data, due });
        }
    }
}

/// Largest number of waiting frames: endless requests do not get endless answers.
const MOST_WAITING: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    const NAME: Name = Name {
        identity: 1000,
        manufacturer: 2047,
        ecu_instance: 0,
        function_instance: 0,
        function: 255,
        vehicle_system: 127,
        vehicle_system_instance: 0,
        industry_group: 3,
        arbitrary_address: true,
    };
    const CLAIM_OF_80: u32 = 0x18ee_ff80;

    fn node(arbitrary_address: bool) -> Node {
        let name = Name {
            arbitrary_address,
            ..NAME
        };
        let mut node = Node::new(name, 0x80, vec![0xff10]);
        node.begin(0);
        node
    }

    fn said(node: &mut Node, now: u64) -> Vec<(u32, [u8; 8])> {
        std::iter::from_fn(|| node.say(now))
            .map(|s| (s.id, s.data))
            .collect()
    }

    #[test]
    fn the_name_lies_in_its_bits() {
        let name = Name {
            identity: 0x1f_ffff,
            manufacturer: 0,
            ecu_instance: 7,
            function_instance: 0,
            function: 0xff,
            vehicle_system: 0,
            vehicle_system_instance: 0xf,
            industry_group: 0,
            arbitrary_address: true,
        };
        assert_eq!(name.bits(), 0x8f00_ff07_001f_ffff);
        // One bit between function and vehicle system is reserved, 0.
        assert_eq!(NAME.bits() >> 48 & 1, 0);
    }

    #[test]
    fn an_address_is_used_a_quarter_of_a_second_after_its_claim() {
        let mut node = node(true);
        assert_eq!(
            said(&mut node, 0),
            [(CLAIM_OF_80, NAME.bits().to_le_bytes())]
        );
        assert_eq!(node.address(WAIT - 1), None);
        assert_eq!(node.address(WAIT), Some(0x80));
    }

    #[test]
    fn a_weaker_claim_is_answered_and_a_stronger_one_makes_way() {
        for now in [WAIT / 2, 2 * WAIT] {
            let mut node = node(true);
            said(&mut node, 0);
            node.address(now);
            node.take(CLAIM_OF_80, &u64::MAX.to_le_bytes(), now);
            assert_eq!(said(&mut node, now).len(), 1, "defended");
            assert_eq!(node.address(2 * WAIT), Some(0x80));
            node.take(CLAIM_OF_80, &1_u64.to_le_bytes(), 2 * WAIT);
            assert_eq!(node.address(2 * WAIT), None, "nothing is sent meanwhile");
            assert_eq!(said(&mut node, 2 * WAIT)[0].0, 0x18ee_ff81);
            assert_eq!(node.address(3 * WAIT), Some(0x81));
        }
    }

    #[test]
    fn a_node_that_may_not_choose_says_that_it_cannot_claim_and_is_silent() {
        let mut node = node(false);
        said(&mut node, 0);
        node.take(CLAIM_OF_80, &1_u64.to_le_bytes(), 1);
        let later = 1 + MOST_DELAY;
        let answers = said(&mut node, later);
        assert_eq!(answers.len(), 1);
        assert_eq!(answers[0].0, 0x18ee_fffe);
        assert_eq!(node.address(10 * WAIT), None);
        assert!(node.has_lost());
        node.take(0x18ea_ff01, &[0x00, 0xee, 0x00], later);
        assert_eq!(said(&mut node, later + MOST_DELAY)[0].0, 0x18ee_fffe);
    }

    #[test]
    fn a_node_of_the_same_name_is_noticed_wherever_it_is() {
        for claim in [CLAIM_OF_80, 0x18ee_ff93] {
            let mut node = node(true);
            node.take(CLAIM_OF_80, &1_u64.to_le_bytes(), 1);
            assert!(!node.has_double());
            node.take(claim, &NAME.bits().to_le_bytes(), 2);
            assert!(node.has_double());
        }
    }

    #[test]
    fn where_every_address_is_taken_there_is_none() {
        let mut node = node(true);
        for address in FREE.rev() {
            let id = 0x18ee_ff00 | u32::from(address);
            node.take(id, &u64::from(address).to_le_bytes(), 1);
        }
        assert_eq!(node.address(10 * WAIT), None);
        assert!(node.has_lost());
    }

    #[test]
    fn requests_are_answered_by_claim_by_group_or_by_a_refusal() {
        let mut node = node(true);
        said(&mut node, 0);
        node.address(WAIT);
        for to in [0x80, 0xff] {
            let id = 0x18ea_0001 | to << 8;
            node.take(id, &[0x00, 0xee, 0x00], WAIT);
            assert_eq!(said(&mut node, WAIT)[0].0, CLAIM_OF_80);
            node.take(id, &[0x10, 0xff, 0x00], WAIT);
            assert_eq!(node.take_asked(), [0xff10]);
        }
        node.take(0x18ea_8001, &[0xeb, 0xfe, 0x00], WAIT);
        let refusal = [1, 0xff, 0xff, 0xff, 1, 0xeb, 0xfe, 0x00];
        assert_eq!(said(&mut node, WAIT), [(0x18e8_ff80, refusal)]);
        node.take(0x18ea_ff01, &[0xeb, 0xfe, 0x00], WAIT);
        node.take(0x18ea_8101, &[0x00, 0xee, 0x00], WAIT);
        assert!(
            said(&mut node, WAIT).is_empty(),
            "asked of all, or of another"
        );
    }

    #[test]
    fn no_frame_makes_more_than_a_few() {
        let mut node = node(true);
        for i in 0..1000_u64 {
            node.take(CLAIM_OF_80, &u64::MAX.to_le_bytes(), i);
            node.take(0x18ea_ff01, &[0x00, 0xee, 0x00], i);
            node.take(0x18ea_ff01, &[], i);
            node.take(CLAIM_OF_80, &[1, 2], i);
        }
        assert!(said(&mut node, 1000).len() <= MOST_WAITING);
    }
}
